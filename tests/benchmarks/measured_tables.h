// Rows of sweeps as Markdown tables and as figures, as templates of pages ask for them.
#pragma once

#include <string>
#include <string_view>

#include "benchmarks/page_data.h"

namespace acus::benchmarks {

/// One line of what a template asks for: "key name = meaning".
struct AskedLine {
  std::string key;
  std::string name;
  std::string meaning;  ///< As `name` if there is none.
};
/// @throws InputError if a key is not one of `keys`.
std::vector<AskedLine> AskedLines(std::string_view lines, std::string_view keys);

/// Settings below each other, in the order of the sweep; the default is bold, what the paper did is
/// marked, and what must not be used says so.
///
///     sweep tissue
///     knob element_size_mm = element size, mm     (several: a column tells which)
///     column error, N = error N
///     column step, us = step_us_median
///
/// @throws InputError for anything that is not in the sweep.
std::string SettingsTable(std::string_view asked, const PageData& data);

/// Knobs below each other, their values side by side.
///
///     sweep forces
///     title friction: RMS error in mN at
///     at 0.1 = 0.1 ms
///     row friction, implicit Euler: step_ms = implicit Euler
///     cell 1000 * error N                         (several: "a / b")
///     column a step, us = step_us_median @ 1
///     unusable diverges
///
/// @throws InputError for anything that is not in the sweep.
std::string ValuesTable(std::string_view asked, const PageData& data);

/// A plot of one field over another, as SVG.
///
///     sweep tissue
///     title What finer elements buy
///     x step_us_median = median CPU time of a step [us]
///     y error N = error [N]
///     line element_size_mm = element size
///     points model                                (no order: a dot and a name for each value)
///     linear x
///
/// Axes are logarithmic unless they are said to be linear. What is 0, unusable, or below a
/// ten-thousandth of the largest has no place in it.
std::string FigureSvg(std::string_view asked, const PageData& data);

/// A number for a table: two significant digits; 0 for what is rounding; a dash if not measured.
std::string Shown(double value);

}  // namespace acus::benchmarks
