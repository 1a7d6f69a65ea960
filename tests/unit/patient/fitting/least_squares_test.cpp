#include "acus/patient/fitting/least_squares.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/patient/fitting/curve_models.h"

namespace acus::fitting {
namespace {

TEST(Estimate, OneThatIsPossibleStaysAsItIs) {
  const Estimate e = Estimate::Normal(1.0, 0.2).AtLeast(0.0);
  EXPECT_EQ(e.value, 1.0);
  EXPECT_EQ(e.low, Estimate::Normal(1.0, 0.2).low);
  EXPECT_FALSE(e.at_bound);
  EXPECT_EQ(Estimate::Normal(0.1, 0.2).AtLeast(0.0).low, 0.0);
  EXPECT_EQ(Estimate::Normal(0.1, 0.2).AtLeast(0.0).AmongSeveral(10).low, 0.0);
}

TEST(Estimate, BeyondItsBoundItHasAOneSidedInterval) {
  const Estimate free = Estimate::Normal(-0.3, 0.1);
  const Estimate e = free.AtLeast(0.0);
  EXPECT_TRUE(e.at_bound);
  EXPECT_EQ(e.value, 0.0);
  EXPECT_EQ(e.low, 0.0);
  // The profile likelihood falls by half the square of the quantile there.
  const double half = free.high - free.value;
  EXPECT_NEAR(std::pow(-0.3 - e.high, 2) - std::pow(-0.3, 2), half * half, 1e-12);
}

/// 95 % intervals of linear fits whose true slope is at its bound or near it.
TEST(Estimate, BoundedIntervalsHoldTheTruthAtLeastAsOften) {
  for (const double slope : {0.0, 0.002, 0.005, 0.02}) {
    int inside = 0;
    int at_bound = 0;
    const int seeds = 1000;
    for (int seed = 0; seed < seeds; ++seed) {
      RandomStream noise(static_cast<std::uint64_t>(seed), "bounded");
      Samples samples;
      for (std::size_t i = 0; i < 80; ++i) {
        const double x = 0.1 * static_cast<double>(i);
        samples.Add(i, x, 0.3 + slope * x + 0.05 * noise.Normal());
      }
      const ModelFit fit = FitModel(Line(4.0), samples.x, samples.y, {0.0, 0.0}, false);
      const Estimate e = fit.Of(1).AtLeast(0.0);
      inside += e.Contains(slope) ? 1 : 0;
      at_bound += e.at_bound ? 1 : 0;
      EXPECT_GE(e.low, 0.0);
      EXPECT_GE(e.high, e.value);
    }
    std::printf("  slope %.3f: %d of %d inside, %d at the bound\n", slope, inside, seeds, at_bound);
    EXPECT_GE(inside, 930) << slope;
  }
}

/// Stiffness: a level over a length, either of them vague.
TEST(Estimate, RatiosOfPositiveQuantitiesHoldTheTruthAndStayPositive) {
  for (const double level_error : {0.02, 0.15, 0.3}) {
    int inside = 0;
    for (int seed = 0; seed < 1000; ++seed) {
      RandomStream noise(static_cast<std::uint64_t>(seed), "ratio");
      const Estimate level = Estimate::Normal(0.3 + level_error * noise.Normal(), level_error);
      const double log_length = std::log(0.8) + 0.3 * noise.Normal();
      const Estimate of_log = Estimate::Normal(log_length, 0.3);
      const Estimate length{std::exp(log_length), 0.3 * std::exp(log_length), std::exp(of_log.low),
                            std::exp(of_log.high)};
      const Estimate ratio = PositiveRatio(level.AtLeast(0.0), length);
      EXPECT_GE(ratio.low, 0.0);
      EXPECT_GE(ratio.value, ratio.low);
      EXPECT_GE(ratio.high, ratio.value);
      inside += ratio.Contains(0.3 / 0.8) ? 1 : 0;
    }
    std::printf("  level error %.2f: %d of 1000 inside\n", level_error, inside);
    EXPECT_GE(inside, 930) << level_error;
  }
}

}  // namespace
}  // namespace acus::fitting
