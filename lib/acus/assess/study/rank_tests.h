// Tests of two samples by ranks: exact, with ties.
#pragma once

#include <span>
#include <vector>

namespace acus::study {

struct RankTest {
  double statistic = 0.0;  ///< U of the first sample (ties count 1/2), or W+ of the signed ranks.
  double p = 1.0;          ///< Two-sided.
  bool exact = true;       ///< False: normal approximation with correction for ties.
};

/// Wilcoxon-Mann-Whitney (Mann & Whitney 1947). Exact up to 60 values in both samples: the
/// permutation distribution of the sum of mid-ranks, so that ties need no approximation;
/// p = 2 min(P(U <= u), P(U >= u)), at most 1. For more values, normal with corrections for ties
/// and continuity. p is 1 if all values are equal.
/// @pre both samples are not empty and finite.
RankTest MannWhitney(std::span<const double> a, std::span<const double> b);

/// Wilcoxon's signed ranks of paired differences; zeros are dropped (Wilcoxon 1945). Exact up to 60
/// differences. @pre finite.
RankTest WilcoxonSignedRank(std::span<const double> differences);

/// Ranks from 1; equal values share their mean rank.
std::vector<double> MidRanks(std::span<const double> values);

/// Holm's correction of p values for their number (Holm 1979), in the given order.
std::vector<double> HolmCorrected(std::span<const double> p);

}  // namespace acus::study
