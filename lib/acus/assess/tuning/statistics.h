// Means over repetitions, with confidence intervals.
#pragma once

#include <limits>
#include <span>

namespace acus::tuning {

/// A mean and its 95 % confidence interval, mean +- half_width, by Student's t.
struct Estimate {
  double mean = std::numeric_limits<double>::quiet_NaN();  ///< Not a number if there is no value.
  double half_width = std::numeric_limits<double>::quiet_NaN();  ///< ... or fewer than two.
  int count = 0;
};

/// The estimate from the values that are not NaN. An infinite one makes the mean infinite.
Estimate EstimateOf(std::span<const double> values);

/// The estimate of the differences a[i] - b[i], paired: common variation cancels. Pairs with a NaN
/// are omitted. @pre a.size() == b.size().
Estimate PairedDifference(std::span<const double> a, std::span<const double> b);

}  // namespace acus::tuning
