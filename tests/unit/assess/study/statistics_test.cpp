// Published worked examples and closed forms.
#include "acus/base/math/statistics.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "acus/assess/study/analysis.h"
#include "acus/base/core/random.h"

namespace acus::study {
namespace {

using Values = std::vector<double>;

/// Hollander & Wolfe 1973, permeability of the chorioamnion at term and earlier.
TEST(MannWhitney, GivesThePublishedExactP) {
  const Values term = {0.80, 0.83, 1.89, 1.04, 1.45, 1.38, 1.91, 1.64, 0.73, 1.46};
  const Values earlier = {1.15, 0.88, 0.90, 0.74, 1.21};
  const RankTest test = MannWhitney(term, earlier);
  EXPECT_EQ(test.statistic, 35.0);
  EXPECT_TRUE(test.exact);
  EXPECT_NEAR(test.p, 2.0 * 0.1272, 1e-4) << "one-sided 0.1272";
  EXPECT_EQ(MannWhitney(earlier, term).p, test.p);
}

/// Hollander & Wolfe 1973, depression scale before and after treatment.
TEST(WilcoxonSignedRank, GivesThePublishedExactP) {
  const Values before = {1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30};
  const Values after = {0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29};
  Values difference;
  for (std::size_t i = 0; i < before.size(); ++i) difference.push_back(before[i] - after[i]);
  const RankTest test = WilcoxonSignedRank(difference);
  EXPECT_EQ(test.statistic, 40.0);
  EXPECT_NEAR(test.p, 2.0 * 0.01953125, 1e-12);
}

/// All ways to take `a.size()` of the values, one by one.
double EnumeratedP(const Values& a, const Values& b) {
  Values all = a;
  all.insert(all.end(), b.begin(), b.end());
  const auto u_of = [&](unsigned chosen) {
    double u = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t j = 0; j < all.size(); ++j) {
        if (((chosen >> i) & 1U) == 0 || ((chosen >> j) & 1U) != 0) continue;
        u += all[i] > all[j] ? 1.0 : all[i] == all[j] ? 0.5 : 0.0;
      }
    }
    return u;
  };
  const double observed = u_of((1U << a.size()) - 1U);
  double below = 0.0, above = 0.0, count = 0.0;
  for (unsigned chosen = 0; chosen < (1U << all.size()); ++chosen) {
    if (static_cast<std::size_t>(__builtin_popcount(chosen)) != a.size()) continue;
    const double u = u_of(chosen);
    count += 1.0;
    if (u <= observed) below += 1.0;
    if (u >= observed) above += 1.0;
  }
  return std::min(1.0, 2.0 * std::min(below, above) / count);
}

TEST(MannWhitney, IsExactWithTies) {
  for (const auto& [a, b] : {std::pair{Values{1, 2, 2, 3}, Values{2, 3, 3, 4, 5}},
                             {Values{0, 0, 0, 1}, Values{0, 1, 1, 1, 1}},
                             {Values{7}, Values{1, 2, 3}},
                             {Values{2, 2}, Values{2, 2, 2}}}) {
    EXPECT_NEAR(MannWhitney(a, b).p, EnumeratedP(a, b), 1e-14);
  }
  EXPECT_EQ(MannWhitney(Values{2, 2}, Values{2, 2, 2}).p, 1.0);
}

TEST(MannWhitney, LargeSamplesAgreeWithTheExactDistribution) {
  // 60 values are exact, 61 are not: one more in the middle changes p little.
  Values a(30), b(30);
  std::iota(a.begin(), a.end(), 0.0);
  std::iota(b.begin(), b.end(), 8.5);
  const RankTest exact = MannWhitney(a, b);
  b.push_back(23.25);
  const RankTest approximate = MannWhitney(a, b);
  EXPECT_TRUE(exact.exact);
  EXPECT_FALSE(approximate.exact);
  EXPECT_NEAR(approximate.p, exact.p, 0.1 * exact.p);
}

TEST(MannWhitney, LargeSamplesWithTiesHaveTheVarianceOfTheirRanks) {
  // The rank sum of m of N values drawn without replacement: variance m n / (N (N - 1)) times the
  // sum of the squared deviations of all mid-ranks.
  Values a, b;
  for (int i = 0; i < 40; ++i) a.push_back(i % 4);
  for (int i = 0; i < 50; ++i) b.push_back(i % 5);
  Values all = a;
  all.insert(all.end(), b.begin(), b.end());
  const Values ranks = MidRanks(all);
  double squares = 0.0, rank_sum = 0.0;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    squares += (ranks[i] - 45.5) * (ranks[i] - 45.5);
    if (i < a.size()) rank_sum += ranks[i];
  }
  const double sd = std::sqrt(40.0 * 50.0 / (90.0 * 89.0) * squares);
  const double off = std::abs(rank_sum - 40.0 * 45.5) - 0.5;
  EXPECT_NEAR(MannWhitney(a, b).p, std::erfc(off / sd / std::sqrt(2.0)), 1e-12);
}

TEST(WilcoxonSignedRank, LargeSamplesWithTiesAgreeWithTheExactDistribution) {
  // 24 differences of each of three sizes, of ranks 12.5, 36.5 and 60.5: the number of positive
  // ones of a size is binomial.
  constexpr int kOfASize = 24;
  const std::vector<int> positive = {15, 15, 16};
  Values differences;
  for (int size = 1; size <= 3; ++size) {
    for (int i = 0; i < kOfASize; ++i) {
      differences.push_back(i < positive[static_cast<std::size_t>(size - 1)] ? size : -size);
    }
  }
  const auto statistic = [](int a, int b, int c) { return 12.5 * a + 36.5 * b + 60.5 * c; };
  const double observed = statistic(positive[0], positive[1], positive[2]);
  Values share(kOfASize + 1, std::exp2(-kOfASize));
  for (std::size_t k = 1; k < share.size(); ++k) {
    share[k] = share[k - 1] * static_cast<double>(kOfASize + 1 - k) / static_cast<double>(k);
  }
  double above = 0.0;
  for (int a = 0; a <= kOfASize; ++a) {
    for (int b = 0; b <= kOfASize; ++b) {
      for (int c = 0; c <= kOfASize; ++c) {
        if (statistic(a, b, c) < observed) continue;
        above += share[static_cast<std::size_t>(a)] * share[static_cast<std::size_t>(b)] *
                 share[static_cast<std::size_t>(c)];
      }
    }
  }
  const RankTest test = WilcoxonSignedRank(differences);
  EXPECT_FALSE(test.exact);
  EXPECT_EQ(test.statistic, observed);
  // Normal with the mean and variance of the sum: a quarter of the sum of squared ranks.
  const double variance = kOfASize * (12.5 * 12.5 + 36.5 * 36.5 + 60.5 * 60.5) / 4.0;
  const double off = observed - statistic(kOfASize, kOfASize, kOfASize) / 2.0 - 0.5;
  EXPECT_NEAR(test.p, std::erfc(off / std::sqrt(2.0 * variance)), 1e-12);
  EXPECT_NEAR(test.p, 2.0 * above, 0.05 * 2.0 * above) << "12 % off without regard to ties";
}

TEST(HolmCorrected, StepsDown) {
  const Values corrected = HolmCorrected(Values{0.01, 0.04, 0.03});
  EXPECT_NEAR(corrected[0], 0.03, 1e-15);
  EXPECT_NEAR(corrected[1], 0.06, 1e-15);
  EXPECT_NEAR(corrected[2], 0.06, 1e-15);
}

/// Shrout & Fleiss 1979, table 2: four ratings of six targets.
Eigen::MatrixXd Ratings() {
  Eigen::MatrixXd ratings(6, 4);
  ratings << 9, 2, 5, 8, 6, 1, 3, 2, 8, 4, 6, 8, 7, 1, 2, 6, 10, 5, 6, 9, 6, 2, 4, 7;
  return ratings;
}

TEST(ComputeIcc, GivesTheSixPublishedForms) {
  const IntraclassCorrelation icc = ComputeIcc(Ratings()).value();
  EXPECT_NEAR(icc.icc_1_1, 0.17, 0.005);
  EXPECT_NEAR(icc.icc_2_1, 0.29, 0.005);
  EXPECT_NEAR(icc.icc_3_1, 0.71, 0.005);
  EXPECT_NEAR(icc.icc_1_k, 0.44, 0.005);
  EXPECT_NEAR(icc.icc_2_k, 0.62, 0.005);
  EXPECT_NEAR(icc.icc_3_k, 0.91, 0.005);
  EXPECT_FALSE(ComputeIcc(Eigen::MatrixXd::Ones(3, 2)));
}

TEST(CronbachAlpha, IsTheThirdFormOfTheMean) {
  EXPECT_NEAR(CronbachAlpha(Ratings()).value(), ComputeIcc(Ratings())->icc_3_k, 1e-14);
  Eigen::MatrixXd same(3, 2);
  same << 1, 1, 2, 2, 5, 5;
  EXPECT_NEAR(CronbachAlpha(same).value(), 1.0, 1e-14);
  EXPECT_FALSE(CronbachAlpha(Eigen::MatrixXd::Ones(3, 2)));
}

TEST(EffectSize, ClosedForms) {
  EXPECT_EQ(AreaUnderCurve(Values{1, 2, 3}, Values{4, 5}), 0.0);
  EXPECT_EQ(AreaUnderCurve(Values{1, 3}, Values{2}), 0.5);
  EXPECT_EQ(AreaUnderCurve(Values{2, 3}, Values{2}), 0.75);
  EXPECT_EQ(CliffsDelta(Values{2, 3}, Values{2}), 0.5);
  EXPECT_NEAR(HedgesG(Values{1, 2, 3}, Values{4, 5, 6}), -3.0 * 0.8, 1e-14);
}

/// Of groups that differ without scatter, the difference has no scale: 0 would say that they are
/// alike.
TEST(EffectSize, ThereIsNoHedgesGWithoutScatter) {
  EXPECT_TRUE(std::isnan(HedgesG(Values{1, 1}, Values{2, 2})));
  EXPECT_TRUE(std::isnan(HedgesG(Values{0.1, 0.1, 0.1}, Values{0.3, 0.3, 0.3})));
  EXPECT_TRUE(std::isnan(HedgesG(Values{0, 0}, Values{0, 0})));
  EXPECT_LT(HedgesG(Values{1, 1}, Values{2, 3}), -1.0);
}

/// Draws of the noncentral t: the interval holds the true g as often as it says.
TEST(EffectSize, TheIntervalOfGHoldsTheTruth) {
  for (const auto& [size, truth] : {std::pair{2, 1.0}, {4, -1.5}, {12, 0.4}}) {
    RandomStream random(7, "groups");
    int held = 0;
    constexpr int kStudies = 400;
    for (int study = 0; study < kStudies; ++study) {
      Values a(static_cast<std::size_t>(size)), b(a.size());
      for (double& x : a) x = truth + random.Normal();
      for (double& x : b) x = random.Normal();
      const Interval interval = IntervalOfG(HedgesG(a, b), a.size(), b.size(), 0.95);
      const double count = 2.0 * size;
      const double expected = truth * (1.0 - 3.0 / (4.0 * count - 9.0));
      held += interval.low <= expected && expected <= interval.high ? 1 : 0;
    }
    EXPECT_NEAR(held, 0.95 * kStudies, 14) << size;  // Three standard errors.
  }
}

TEST(EffectSize, TheIntervalOfGGoesOverIntoThatOfFarGroups) {
  const double scale = std::sqrt(6.0 * 6.0 / 12.0), correction = 1.0 - 3.0 / 39.0;
  const Interval near = IntervalOfG(59.99 / scale * correction, 6, 6, 0.95);
  const Interval far = IntervalOfG(60.01 / scale * correction, 6, 6, 0.95);
  EXPECT_NEAR(near.low, far.low, 0.02 * far.low);
  EXPECT_NEAR(near.high, far.high, 0.02 * far.high);
}

/// Cohen 1988, table 2.4.1: two-sided 0.05, power 0.80.
TEST(SizeForPower, GivesCohensTable) {
  EXPECT_EQ(SizeForPower(0.5, 0.8, 0.05).t_test, 64);
  EXPECT_EQ(SizeForPower(-0.8, 0.8, 0.05).t_test, 26);
  EXPECT_NEAR(SizeForPower(0.2, 0.8, 0.05).t_test, 393, 1);
  EXPECT_EQ(SizeForPower(0.5, 0.8, 0.05).mann_whitney, 68);
  EXPECT_EQ(SizeForPower(0.0, 0.8, 0.05).t_test, 0);
  EXPECT_GE(SizeForPower(50.0, 0.8, 0.05).t_test, 2);
  EXPECT_NEAR(PowerOfTTest(0.0, 10, 0.05), 0.05, 1e-12);
}

TEST(BootstrapInterval, HasTheWidthOfTheStandardErrorAndTheSeed) {
  RandomStream random(3, "samples");
  Values a(200), b(200);
  for (double& x : a) x = random.Normal();
  for (double& x : b) x = 1.0 + random.Normal();
  const auto difference = [](std::span<const double> x, std::span<const double> y) {
    return math::Mean(x) - math::Mean(y);
  };
  const Interval interval = BootstrapInterval(a, b, difference, 0.95, 4000, 1, "mean");
  const double error = std::sqrt(
      (std::pow(math::StandardDeviation(a), 2) + std::pow(math::StandardDeviation(b), 2)) / 200.0);
  EXPECT_NEAR(interval.high - interval.low, 2.0 * 1.96 * error, 0.1 * error * 3.92);
  EXPECT_LT(interval.low, difference(a, b));
  EXPECT_GT(interval.high, difference(a, b));
  EXPECT_EQ(BootstrapInterval(a, b, difference, 0.95, 500, 1, "mean").low,
            BootstrapInterval(a, b, difference, 0.95, 500, 1, "mean").low);
}

TEST(Describe, QuartilesOfTypeSeven) {
  const Description d = Describe(Values{1, 2, 3, 4});
  EXPECT_EQ(d.n, 4);
  EXPECT_EQ(d.median, 2.5);
  EXPECT_EQ(d.quartile_1, 1.75);
  EXPECT_EQ(d.quartile_3, 3.25);
  EXPECT_NEAR(d.sd, std::sqrt(5.0 / 3.0), 1e-15);
  EXPECT_EQ(Describe(Values{7}).sd, 0.0);
}

}  // namespace
}  // namespace acus::study
