#include "acus/assess/study/effect_size.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/statistics.h"

namespace acus::study {
namespace {

constexpr int kMostPerGroup = 100'000;
constexpr double kRounding = 1e-12;

}  // namespace

double AreaUnderCurve(std::span<const double> a, std::span<const double> b) {
  ACUS_ASSERT(!a.empty() && !b.empty());
  double sum = 0.0;
  for (const double x : a) {
    for (const double y : b) sum += x > y ? 1.0 : x == y ? 0.5 : 0.0;
  }
  return sum / (static_cast<double>(a.size()) * static_cast<double>(b.size()));
}

double CliffsDelta(std::span<const double> a, std::span<const double> b) {
  return 2.0 * AreaUnderCurve(a, b) - 1.0;
}

double HedgesG(std::span<const double> a, std::span<const double> b) {
  const double m = static_cast<double>(a.size());
  const double n = static_cast<double>(b.size());
  const double sd_a = math::StandardDeviation(a);
  const double sd_b = math::StandardDeviation(b);
  const double pooled =
      std::sqrt(((m - 1.0) * sd_a * sd_a + (n - 1.0) * sd_b * sd_b) / (m + n - 2.0));
  double largest = 0.0;
  for (const double x : a) largest = std::max(largest, std::abs(x));
  for (const double x : b) largest = std::max(largest, std::abs(x));
  if (!(pooled > kRounding * largest)) return std::numeric_limits<double>::quiet_NaN();
  return (math::Mean(a) - math::Mean(b)) / pooled * (1.0 - 3.0 / (4.0 * (m + n) - 9.0));
}

Interval IntervalOfG(double g, std::size_t m, std::size_t n, double confidence) {
  const double count = static_cast<double>(m + n);
  const double scale = std::sqrt(static_cast<double>(m) * static_cast<double>(n) / count);
  const double correction = 1.0 - 3.0 / (4.0 * count - 9.0);
  const double degrees = count - 2.0;
  const double t = g / correction * scale;
  // Far out, T is the shift over an estimated SD, and the scatter about the shift adds nothing.
  constexpr double kFarOut = 60.0;
  constexpr double kReach = 10.0;
  const boost::math::chi_squared squares(degrees);
  const double least = std::sqrt(quantile(squares, 0.5 - 0.5 * confidence) / degrees);
  const double most = std::sqrt(quantile(squares, 0.5 + 0.5 * confidence) / degrees);
  if (t > kFarOut) return {g * least, g * most};
  if (t < -kFarOut) return {g * most, g * least};
  // The shift of which a t as great as this, or as small, is as rare as the confidence says.
  const auto shift_with = [&](double share_below) {
    double low = -std::abs(t) * most - kReach, high = std::abs(t) * most + kReach;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      const double below = std::abs(middle) < 1e-9
                               ? cdf(boost::math::students_t(degrees), t)
                               : cdf(boost::math::non_central_t(degrees, middle), t);
      (below > share_below ? low : high) = middle;
    }
    return 0.5 * (low + high) / scale * correction;
  };
  return {shift_with(0.5 + 0.5 * confidence), shift_with(0.5 - 0.5 * confidence)};
}

Interval BootstrapInterval(std::span<const double> a, std::span<const double> b,
                           const TwoSampleStatistic& statistic, double confidence, int draws,
                           std::uint64_t seed, std::string_view name) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(draws));
  RandomStream random(seed, name);
  for (int draw = 0; draw < draws; ++draw) {
    const auto again_a = math::Redrawn(a, random);
    const auto again_b = math::Redrawn(b, random);
    const double value = statistic(again_a, again_b);
    if (!std::isnan(value)) values.push_back(value);
  }
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  if (values.empty()) return {kNaN, kNaN};
  return math::PercentileInterval(values, confidence);
}

double PowerOfTTest(double effect, double per_group, double alpha) {
  ACUS_ASSERT(per_group >= 2.0 && alpha > 0.0 && alpha < 1.0);
  const double degrees = 2.0 * per_group - 2.0;
  const double critical = quantile(complement(boost::math::students_t(degrees), 0.5 * alpha));
  const double shift = std::abs(effect) * std::sqrt(0.5 * per_group);
  // The opposite tail also counts: it matters for tiny effects only.
  if (shift == 0.0) return alpha;
  const boost::math::non_central_t alternative(degrees, shift);
  return cdf(complement(alternative, critical)) + cdf(alternative, -critical);
}

SampleSize SizeForPower(double effect, double power, double alpha) {
  if (effect == 0.0) return {};
  int low = 1, high = 2;
  while (high <= kMostPerGroup && PowerOfTTest(effect, high, alpha) < power) {
    low = high;
    high *= 2;
  }
  if (high > kMostPerGroup) return {};
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (middle >= 2 && PowerOfTTest(effect, middle, alpha) >= power ? high : low) = middle;
  }
  return {high, static_cast<int>(std::ceil(high * std::numbers::pi / 3.0))};
}

}  // namespace acus::study
