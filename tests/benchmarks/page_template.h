// Pages with measured numbers, from templates that hold no number themselves.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/page_data.h"

namespace acus::benchmarks {

/// What a page is for decides what becomes of a sentence that is not true.
enum class Claims {
  kMustHold,  ///< A page of the documentation: all claims hold, all numbers are there, or no page.
  kAreMarked  ///< A run on another machine, or a quick one: the page says where it is not so.
};

struct Page {
  std::string text;                            ///< Markdown.
  std::map<std::string, std::string> figures;  ///< SVG by name; the text shows figures/NAME.svg.
};

/// Fills in a template. Between {{ and }} may stand:
///
///     = EXPRESSION : DIGITS        a number, with two significant digits unless told otherwise
///     text FILE | key              a fact as it is stored
///     require CLAIM                nothing, if that holds (expression.h); before or behind the
///                                  sentence that says so
///     table, pivot, figure NAME    and what is asked for, line by line (measured_tables.h)
///
/// A line that holds nothing but a claim leaves no empty line.
/// @throws InputError that lists, by line of the template, all that cannot be understood and, if
///     claims must hold, all that do not hold and all that was not measured.
Page MakePage(std::string_view text, const PageData& data, Claims claims);

}  // namespace acus::benchmarks
