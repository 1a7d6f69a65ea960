// One line of a verdict.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace acus::comparison {

/// A quantity of two runs, held against its tolerance.
struct Check {
  std::string quantity;
  std::string unit;             ///< Empty for a count or a ratio.
  std::optional<double> value;  ///< Nothing where there is no number, such as PSNR of equal images.
  std::optional<double> limit;  ///< Nothing if there is no limit but equality.
  bool at_least = false;        ///< The value must be at least the limit; otherwise at most.
  bool passed = false;
  std::string remark;        ///< What differs, and where.
  bool only_in_one = false;  ///< One run alone has it, so that there is nothing to compare.
};

/// value <= limit.
Check AtMost(std::string quantity, std::string unit, double value, double limit,
             std::string remark = "");

/// Passes or fails without a number.
Check Verdict(std::string quantity, bool passed, std::string remark);

/// Of what one run alone has; not passed. @param remark  Which run.
Check OnlyInOne(std::string quantity, std::string remark);

}  // namespace acus::comparison
