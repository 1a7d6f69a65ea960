// One line of a verdict.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace acus::comparison {

/// A quantity of two runs, compared with its tolerance.
struct Check {
  std::string quantity;
  std::string unit;             ///< Empty for a count or a ratio.
  std::optional<double> value;  ///< Nothing if there is no number, such as PSNR of equal images.
  std::optional<double> limit;  ///< Nothing if only equality passes.
  bool at_least = false;        ///< The value must be at least the limit; otherwise at most.
  bool passed = false;
  std::string remark;        ///< The difference, and where it is.
  bool only_in_one = false;  ///< Only one run has it: there is no comparison.
};

/// value <= limit.
Check AtMost(std::string quantity, std::string unit, double value, double limit,
             std::string remark = "");

/// Passes or fails without a number.
Check Verdict(std::string quantity, bool passed, std::string remark);

/// A failed check of a quantity that only one run has. @param remark  Which run.
Check OnlyInOne(std::string quantity, std::string remark);

}  // namespace acus::comparison
