// What accuracy costs: a knob is turned, and error and time are measured in the same run.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::benchmarks {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// One setting of one knob against one reference.
struct Row {
  std::string knob;    ///< Such as "element size", with its unit: "element_size_mm".
  std::string value;   ///< Of the knob, as text; a number where the knob is one.
  std::string model;   ///< The model whose knob it is.
  double error = 0.0;  ///< In error_unit, >= 0.
  std::string error_unit;
  std::string reference;                 ///< What the error is against.
  double step_us_median = kNotMeasured;  ///< CPU time of one step of the model, us.
  double step_us_p999 = kNotMeasured;    ///< 99.9th percentile, us.
  double preparation_s = kNotMeasured;   ///< CPU time before the first step, s.
  double memory_mb = kNotMeasured;       ///< What the steps read, 10^6 bytes.
  bool is_default = false;               ///< What Acus does unless told otherwise.
  bool is_paper = false;                 ///< What the paper did that the model is from.
  /// Why the row must not be used: forces out of bounds, or energy from nothing. A solver that has
  /// diverged can look fast. Empty: it may be used.
  std::string unusable;
};

/// A sweep over the knobs of one part of the simulator.
struct Sweep {
  std::string_view name;
  std::string_view title;
  std::string_view about;  ///< What was done, in a sentence or two, for the report.
  /// @param quick  Few and coarse settings: seconds instead of minutes.
  std::function<std::vector<Row>(bool quick, const RunContext& context)> run;
};

/// All sweeps, by name.
const std::vector<Sweep>& Sweeps();

/// @throws InputError that lists the names if there is none of that name.
const Sweep& SweepNamed(std::string_view name);

}  // namespace acus::benchmarks
