// Confidence intervals that hold for any distribution, also of small samples.
#pragma once

#include <optional>
#include <span>

#include "acus/base/math/bootstrap.h"

namespace acus::math {

/// Interval of the probability of an event that was seen so often (Clopper & Pearson 1934): covers
/// it with at least the confidence. @pre 0 <= seen <= trials, trials > 0, confidence in (0, 1).
Interval ShareInterval(int seen, int trials, double confidence);

/// Interval of the median, between two order statistics: covers it with at least the confidence.
/// Nothing if the sample is too small: fewer than 6 values for 95 %. @pre confidence in (0, 1).
std::optional<Interval> MedianInterval(std::span<const double> values, double confidence);

}  // namespace acus::math
