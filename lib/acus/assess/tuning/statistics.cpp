#include "acus/assess/tuning/statistics.h"

#include <cmath>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"

namespace acus::tuning {

Estimate EstimateOf(std::span<const double> values) {
  std::vector<double> numbers;
  for (const double value : values) {
    if (!std::isnan(value)) numbers.push_back(value);
  }
  Estimate estimate;
  estimate.count = static_cast<int>(numbers.size());
  if (numbers.empty()) return estimate;
  estimate.mean = math::Mean(numbers);
  if (numbers.size() < 2 || !std::isfinite(estimate.mean)) return estimate;
  estimate.half_width = math::StudentQuantile(0.975, estimate.count - 1.0) *
                        math::StandardDeviation(numbers) /
                        std::sqrt(static_cast<double>(numbers.size()));
  return estimate;
}

Estimate PairedDifference(std::span<const double> a, std::span<const double> b) {
  ACUS_ASSERT(a.size() == b.size());
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) differences.push_back(a[i] - b[i]);
  return EstimateOf(differences);
}

}  // namespace acus::tuning
