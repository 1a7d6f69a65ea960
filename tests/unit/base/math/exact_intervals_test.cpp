#include "acus/base/math/exact_intervals.h"

#include <cmath>
#include <gmock/gmock.h>
#include <vector>

namespace acus::math {
namespace {

TEST(ShareInterval, IsThatOfClopperAndPearson) {
  // With none or all seen the bound has a closed form: 1 - (alpha / 2)^(1 / n).
  EXPECT_EQ(ShareInterval(0, 12, 0.95).low, 0.0);
  EXPECT_NEAR(ShareInterval(0, 12, 0.95).high, 1.0 - std::pow(0.025, 1.0 / 12.0), 1e-12);
  EXPECT_NEAR(ShareInterval(12, 12, 0.95).low, std::pow(0.025, 1.0 / 12.0), 1e-12);
  EXPECT_EQ(ShareInterval(12, 12, 0.95).high, 1.0);
  // Each bound leaves half of alpha: P(X >= 3 | low) = P(X <= 3 | high) = 0.025, n = 10.
  const Interval three = ShareInterval(3, 10, 0.95);
  const auto at_most = [](int k, double p) {
    double sum = 0.0, chance = std::pow(1.0 - p, 10);
    for (int i = 0; i <= k; ++i) {
      sum += chance;
      chance *= (10.0 - i) / (i + 1.0) * p / (1.0 - p);
    }
    return sum;
  };
  EXPECT_NEAR(1.0 - at_most(2, three.low), 0.025, 1e-10);
  EXPECT_NEAR(at_most(3, three.high), 0.025, 1e-10);
}

TEST(MedianInterval, LiesBetweenOrderStatistics) {
  const std::vector<double> five = {5, 1, 4, 2, 3};
  EXPECT_FALSE(MedianInterval(five, 0.95)) << "covers it with 1 - 2 / 32 only";
  EXPECT_TRUE(MedianInterval(five, 0.9));
  EXPECT_FALSE(MedianInterval({}, 0.95));
  std::vector<double> values;
  for (int i = 1; i <= 20; ++i) values.push_back(21 - i);
  // Ranks 6 and 15 of 20, as tables of the sign test have them (1 - 2 P(X <= 5) = 0.9586).
  const auto interval = MedianInterval(values, 0.95);
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->low, 6.0);
  EXPECT_EQ(interval->high, 15.0);
}

TEST(MedianInterval, CoversTheMedianAsOftenAsItSays) {
  RandomStream random(3, "skewed");
  for (const int size : {6, 9, 15, 40}) {
    int covered = 0;
    constexpr int kSamples = 2000;
    for (int sample = 0; sample < kSamples; ++sample) {
      std::vector<double> values(static_cast<std::size_t>(size));
      for (double& value : values) value = std::exp(random.Normal());
      const auto interval = MedianInterval(values, 0.95);
      ASSERT_TRUE(interval);
      covered += interval->low <= 1.0 && 1.0 <= interval->high;
    }
    EXPECT_GE(covered, 0.94 * kSamples) << size;
  }
}

TEST(BootstrapIntervalOfMean, HasTheWidthOfTheStandardErrorAndTheSeed) {
  RandomStream random(1, "sample");
  std::vector<double> values(60);
  for (double& value : values) value = random.Normal();
  double mean = 0.0, squares = 0.0;
  for (const double value : values) mean += value / 60.0;
  for (const double value : values) squares += (value - mean) * (value - mean) / 60.0;
  const Interval interval = BootstrapIntervalOfMean(values, 0.95, 4000, 1, "mean");
  const double width = 2.0 * 1.96 * std::sqrt(squares / 60.0);
  EXPECT_NEAR((interval.high - interval.low) / width, 1.0, 0.05);
  EXPECT_NEAR(0.5 * (interval.low + interval.high), mean, 0.1 * width);
  EXPECT_EQ(BootstrapIntervalOfMean(values, 0.95, 500, 1, "mean").low,
            BootstrapIntervalOfMean(values, 0.95, 500, 1, "mean").low);
  EXPECT_NE(BootstrapIntervalOfMean(values, 0.95, 500, 1, "mean").low,
            BootstrapIntervalOfMean(values, 0.95, 500, 2, "mean").low);
}

}  // namespace
}  // namespace acus::math
