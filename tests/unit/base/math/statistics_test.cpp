#include "acus/base/math/statistics.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace acus::math {
namespace {

const std::vector<double> kSample = {4.0, -1.0, 7.0, 2.0};

TEST(Statistics, MomentsOfASmallSample) {
  EXPECT_DOUBLE_EQ(Mean(kSample), 3.0);
  // Squared deviations 1, 16, 16 and 1.
  EXPECT_DOUBLE_EQ(StandardDeviation(kSample), std::sqrt(34.0 / 3.0));
  EXPECT_DOUBLE_EQ(RootMeanSquare(kSample), std::sqrt(70.0 / 4.0));
  EXPECT_EQ(StandardDeviation(std::vector<double>(5, 0.3)), 0.0);
  EXPECT_DOUBLE_EQ(StandardDeviation(std::vector{1.0, 3.0}), std::sqrt(2.0)) << "two are enough";
}

TEST(Statistics, QuantilesInterpolateBetweenOrderStatistics) {
  EXPECT_EQ(Quantile(kSample, 0.0), -1.0);
  EXPECT_EQ(Quantile(kSample, 1.0), 7.0);
  EXPECT_DOUBLE_EQ(Quantile(kSample, 0.25), 1.25);
  EXPECT_DOUBLE_EQ(Quantile(kSample, 0.9), 6.1);
  EXPECT_DOUBLE_EQ(Median(kSample), 3.0);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Median(std::vector<double>{infinite, 1.0, 2.0}), 2.0);
}

TEST(Statistics, RobustDeviationIgnoresAnOutlier) {
  // Deviations from the median 2: 2, 1, 0, 1, 98.
  EXPECT_DOUBLE_EQ(RobustDeviation(std::vector<double>{0.0, 1.0, 2.0, 3.0, 100.0}), 1.4826);
}

}  // namespace
}  // namespace acus::math
