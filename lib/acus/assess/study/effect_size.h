// Effect sizes of two groups, with intervals by bootstrap.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "acus/base/math/bootstrap.h"

namespace acus::study {

using math::Interval;

/// P(a > b) + P(a = b) / 2 for values drawn from both: the area under the ROC curve. 0.5: no
/// effect.
/// @pre both are not empty.
double AreaUnderCurve(std::span<const double> a, std::span<const double> b);

/// P(a > b) - P(a < b), in [-1, 1] (Cliff 1993). @pre both are not empty.
double CliffsDelta(std::span<const double> a, std::span<const double> b);

/// Standardised mean difference (a - b) over the pooled SD, times 1 - 3 / (4 (m + n) - 9) (Hedges
/// 1981). NaN if the values do not scatter within the groups (pooled SD below 1e-12 of the largest
/// value): the difference has no scale then. @pre both have at least two values.
double HedgesG(std::span<const double> a, std::span<const double> b);

/// Interval of g = HedgesG() of m and n values, by the noncentral t distribution: exact for normal
/// values of one SD. @pre m, n >= 2, confidence in (0, 1).
Interval IntervalOfG(double g, std::size_t m, std::size_t n, double confidence);

/// A bootstrap of fewer values than this in a group says nothing about the scatter.
inline constexpr std::size_t kLeastToDrawAgain = 5;

using TwoSampleStatistic =
    std::function<double(std::span<const double> a, std::span<const double> b)>;

/// Percentile interval of a statistic (Efron & Tibshirani 1993): both samples are drawn again with
/// replacement, `draws` times; draws with a statistic of NaN do not count. NaN if none counts.
/// Depends on the seed and the name only.
/// @pre confidence in (0, 1), draws > 0.
Interval BootstrapInterval(std::span<const double> a, std::span<const double> b,
                           const TwoSampleStatistic& statistic, double confidence, int draws,
                           std::uint64_t seed, std::string_view name);

/// P(detecting) of a two-sided test of two groups of `per_group` whose means differ by `effect`
/// SDs, by the noncentral t distribution. @pre per_group >= 2, 0 < alpha < 1.
double PowerOfTTest(double effect, double per_group, double alpha);

/// Smallest size of each group for a power, by PowerOfTTest; for the Mann-Whitney test divided by
/// its asymptotic relative efficiency 3 / pi and rounded up. 0 if the effect is 0 or more than
/// 100,000 would be needed.
struct SampleSize {
  int t_test = 0;
  int mann_whitney = 0;
};
SampleSize SizeForPower(double effect, double power, double alpha);

}  // namespace acus::study
