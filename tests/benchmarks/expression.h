// Arithmetic over measured numbers, as templates of pages write it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "benchmarks/page_data.h"

namespace acus::benchmarks {

/// The value of an expression: numbers, + - * / and parentheses, selectors in brackets (see
/// PageData::Numbers), and min(), max(), mean() of what is in their parentheses, separated by ';',
/// and log() and abs(). A selector that gives several numbers may only stand in min, max and mean.
/// NaN if something in it was not measured.
///
///     max([tissue | element_size_mm | * | step_us_median]) / 2
///
/// @throws InputError if it cannot be understood, or as PageData::Numbers.
double ValueOf(std::string_view expression, const PageData& data);

/// Comparisons of values by <, <= or >, >=, also chained: "2 < [..] < 4"; joined by "and".
struct Claim {
  std::optional<bool> holds;  ///< None: something in it was not measured.
  std::string values;         ///< What was compared: "2 < 5.3 < 4".
};
/// @throws InputError as ValueOf, and if there is no comparison in it.
Claim Check(std::string_view claim, const PageData& data);

}  // namespace acus::benchmarks
