#include "acus/assess/study/rank_tests.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>

#include "acus/base/core/error.h"

namespace acus::study {
namespace {

constexpr std::size_t kMostExact = 60;

/// Twice the mid-ranks: integers.
std::vector<int> DoubledRanks(const std::vector<double>& ranks) {
  std::vector<int> doubled;
  for (const double rank : ranks) doubled.push_back(static_cast<int>(std::lround(2.0 * rank)));
  return doubled;
}

double TwoSided(const std::vector<double>& weight_of_sum, int observed) {
  double below = 0.0, above = 0.0, all = 0.0;
  for (std::size_t sum = 0; sum < weight_of_sum.size(); ++sum) {
    all += weight_of_sum[sum];
    if (static_cast<int>(sum) <= observed) below += weight_of_sum[sum];
    if (static_cast<int>(sum) >= observed) above += weight_of_sum[sum];
  }
  return std::min(1.0, 2.0 * std::min(below, above) / all);
}

/// Number of subsets of `size` of the doubled ranks, by their sum. Exact in a double up to 2^53,
/// beyond that to its relative precision.
std::vector<double> SubsetsBySum(const std::vector<int>& doubled, std::size_t size) {
  const int most = std::accumulate(doubled.begin(), doubled.end(), 0);
  const auto width = static_cast<std::size_t>(most) + 1;
  std::vector<std::vector<double>> count(size + 1, std::vector<double>(width, 0.0));
  count[0][0] = 1.0;
  for (const int rank : doubled) {
    const auto shift = static_cast<std::size_t>(rank);
    for (std::size_t n = size; n >= 1; --n) {
      for (std::size_t sum = width; sum-- > shift;) count[n][sum] += count[n - 1][sum - shift];
    }
  }
  return count[size];
}

double NormalTwoSided(double z) {
  return 2.0 * cdf(complement(boost::math::normal(), std::abs(z)));
}

/// Sum of t^3 - t over groups of equal values.
double TieSum(std::vector<double> values) {
  std::ranges::sort(values);
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    const double t = static_cast<double>(end - i);
    sum += t * t * t - t;
    i = end;
  }
  return sum;
}

}  // namespace

std::vector<double> MidRanks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    const double rank = 0.5 * static_cast<double>(i + 1 + end);
    for (; i < end; ++i) ranks[order[i]] = rank;
  }
  return ranks;
}

RankTest MannWhitney(std::span<const double> a, std::span<const double> b) {
  ACUS_ASSERT(!a.empty() && !b.empty());
  std::vector<double> all(a.begin(), a.end());
  all.insert(all.end(), b.begin(), b.end());
  const std::vector<double> ranks = MidRanks(all);
  const double rank_sum =
      std::accumulate(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(a.size()), 0.0);
  const double m = static_cast<double>(a.size());
  const double n = static_cast<double>(b.size());
  RankTest test;
  test.statistic = rank_sum - 0.5 * m * (m + 1.0);
  if (all.size() <= kMostExact) {
    test.p = TwoSided(SubsetsBySum(DoubledRanks(ranks), a.size()),
                      static_cast<int>(std::lround(2.0 * rank_sum)));
    return test;
  }
  test.exact = false;
  const double total = m + n;
  const double variance = m * n / 12.0 * (total + 1.0 - TieSum(all) / (total * (total - 1.0)));
  const double off = std::abs(test.statistic - 0.5 * m * n);
  test.p = variance > 0.0
               ? std::min(1.0, NormalTwoSided(std::max(0.0, off - 0.5) / std::sqrt(variance)))
               : 1.0;
  return test;
}

RankTest WilcoxonSignedRank(std::span<const double> differences) {
  std::vector<double> sizes, kept;
  for (const double d : differences) {
    if (d == 0.0) continue;
    kept.push_back(d);
    sizes.push_back(std::abs(d));
  }
  RankTest test;
  if (kept.empty()) return test;
  const std::vector<double> ranks = MidRanks(sizes);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i] > 0.0) test.statistic += ranks[i];
  }
  const double n = static_cast<double>(kept.size());
  if (kept.size() <= kMostExact) {
    const std::vector<int> doubled = DoubledRanks(ranks);
    std::vector<double> count(
        static_cast<std::size_t>(std::accumulate(doubled.begin(), doubled.end(), 0)) + 1, 0.0);
    count[0] = 1.0;
    for (const int rank : doubled) {
      for (std::size_t sum = count.size(); sum-- > static_cast<std::size_t>(rank);) {
        count[sum] += count[sum - static_cast<std::size_t>(rank)];
      }
    }
    test.p = TwoSided(count, static_cast<int>(std::lround(2.0 * test.statistic)));
    return test;
  }
  test.exact = false;
  const double variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - TieSum(sizes) / 48.0;
  const double off = std::abs(test.statistic - 0.25 * n * (n + 1.0));
  test.p = std::min(1.0, NormalTwoSided(std::max(0.0, off - 0.5) / std::sqrt(variance)));
  return test;
}

std::vector<double> HolmCorrected(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p[i]; });
  std::vector<double> corrected(p.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, static_cast<double>(p.size() - i) * p[order[i]]);
    corrected[order[i]] = std::min(1.0, largest);
  }
  return corrected;
}

}  // namespace acus::study
