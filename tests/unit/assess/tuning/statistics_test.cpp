#include "acus/assess/tuning/statistics.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::tuning {
namespace {

TEST(Estimate, OfThreeValuesByHand) {
  const std::vector<double> values = {1.0, 2.0, 6.0};
  const Estimate estimate = EstimateOf(values);
  EXPECT_EQ(estimate.count, 3);
  EXPECT_DOUBLE_EQ(estimate.mean, 3.0);
  // Standard deviation sqrt(7), t(2) = 4.3027.
  EXPECT_NEAR(estimate.half_width, 4.302653 * std::sqrt(7.0 / 3.0), 1e-5);
}

TEST(Estimate, NeedsTwoValuesForAnIntervalAndOneForAMean) {
  const double nothing = std::nan("");
  EXPECT_TRUE(std::isnan(EstimateOf({}).mean));
  const std::vector<double> one = {nothing, 4.0, nothing};
  EXPECT_EQ(EstimateOf(one).count, 1);
  EXPECT_EQ(EstimateOf(one).mean, 4.0);
  EXPECT_TRUE(std::isnan(EstimateOf(one).half_width));
  const std::vector<double> infinite = {1.0, INFINITY};
  EXPECT_TRUE(std::isinf(EstimateOf(infinite).mean));
}

TEST(Estimate, TheIntervalHoldsTheTruthInNineteenOfTwentyCases) {
  RandomStream random(3, "intervals");
  int held = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values(4);
    for (double& value : values) value = 10.0 + 3.0 * random.Normal();
    const Estimate estimate = EstimateOf(values);
    held += std::abs(estimate.mean - 10.0) <= estimate.half_width;
  }
  EXPECT_NEAR(static_cast<double>(held) / kTrials, 0.95, 0.015);
}

TEST(PairedDifference, WhatIsCommonDropsOut) {
  RandomStream random(4, "pairs");
  std::vector<double> a(8);
  std::vector<double> b(8);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double common = 100.0 * random.Normal();
    a[i] = common + 2.0 + 0.01 * random.Normal();
    b[i] = common;
  }
  const Estimate difference = PairedDifference(a, b);
  EXPECT_NEAR(difference.mean, 2.0, 0.02);
  EXPECT_LT(difference.half_width, 0.02);
  EXPECT_GT(EstimateOf(a).half_width, 10.0);
}

}  // namespace
}  // namespace acus::tuning
