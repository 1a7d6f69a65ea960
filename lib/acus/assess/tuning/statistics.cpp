#include "acus/assess/tuning/statistics.h"

#include <cmath>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"

namespace acus::tuning {

double StudentT975(int degrees_of_freedom) {
  ACUS_ASSERT(degrees_of_freedom >= 1);
  // The square of a t variable is an F variable with one degree of freedom in the numerator.
  double low = 1.0;
  double high = 20.0;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    (math::FUpperTail(t * t, 1.0, degrees_of_freedom) > 0.05 ? low : high) = t;
  }
  return 0.5 * (low + high);
}

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
  estimate.half_width = StudentT975(estimate.count - 1) * math::StandardDeviation(numbers) /
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
