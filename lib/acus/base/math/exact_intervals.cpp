#include "acus/base/math/exact_intervals.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::math {

using Binomial = boost::math::binomial_distribution<double>;

Interval ShareInterval(int seen, int trials, double confidence) {
  ACUS_ASSERT(trials > 0 && seen >= 0 && seen <= trials);
  const double tail = 0.5 * (1.0 - confidence);
  return {seen == 0 ? 0.0 : Binomial::find_lower_bound_on_p(trials, seen, tail),
          seen == trials ? 1.0 : Binomial::find_upper_bound_on_p(trials, seen, tail)};
}

std::optional<Interval> MedianInterval(std::span<const double> values, double confidence) {
  const std::size_t n = values.size();
  const Binomial below(static_cast<double>(n), 0.5);
  const double tail = 0.5 * (1.0 - confidence);
  // The median lies below the k-th smallest value if fewer than k values are smaller than it.
  std::size_t k = 0;
  while (k + 1 < n && cdf(below, static_cast<double>(k)) <= tail) ++k;
  if (k == 0) return std::nullopt;
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  return Interval{sorted[k - 1], sorted[n - k]};
}

}  // namespace acus::math
