#include "acus/base/math/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::math {

double Mean(std::span<const double> values) {
  ACUS_ASSERT(!values.empty());
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double StandardDeviation(std::span<const double> values) {
  ACUS_ASSERT(values.size() >= 2);
  const double mean = Mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double RootMeanSquare(std::span<const double> values) {
  ACUS_ASSERT(!values.empty());
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Quantile(std::span<const double> values, double fraction) {
  ACUS_ASSERT(!values.empty() && fraction >= 0.0 && fraction <= 1.0);
  std::vector<double> order(values.begin(), values.end());
  const double position = fraction * static_cast<double>(order.size() - 1);
  const auto low = order.begin() + static_cast<std::ptrdiff_t>(position);
  std::nth_element(order.begin(), low, order.end());
  const double share = position - std::floor(position);
  if (share == 0.0) return *low;  // Also where there is no next one, or an infinite one.
  return *low + share * (*std::min_element(low + 1, order.end()) - *low);
}

double Median(std::span<const double> values) {
  return Quantile(values, 0.5);
}

double RobustDeviation(std::span<const double> values) {
  const double median = Median(values);
  std::vector<double> deviations;
  for (const double v : values) deviations.push_back(std::abs(v - median));
  return 1.4826 * Median(deviations);
}

}  // namespace acus::math
