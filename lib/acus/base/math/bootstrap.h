// Intervals of a statistic from the sample alone (Efron & Tibshirani 1993).
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::math {

struct Interval {
  double low = 0.0;
  double high = 0.0;
};

/// As many values, drawn from the sample with replacement. @pre values is not empty.
std::vector<double> Redrawn(std::span<const double> values, RandomStream& random);

/// From the statistics of redrawn samples to the percentile interval.
/// @pre confidence in (0, 1), statistics is not empty.
Interval PercentileInterval(std::span<const double> statistics, double confidence);

/// Interval of the mean. Depends on the seed and the name only.
/// @pre values is not empty, confidence in (0, 1), draws > 0.
Interval BootstrapIntervalOfMean(std::span<const double> values, double confidence, int draws,
                                 std::uint64_t seed, std::string_view name);

}  // namespace acus::math
