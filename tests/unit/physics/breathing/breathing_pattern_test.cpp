#include "acus/physics/breathing/breathing_pattern.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

PatternSettings Irregular() {
  return {.period_s = 3.7,
          .exponent = 3,
          .period_spread = 0.15,
          .speed_spread = 0.6,
          .level_spread = 0.1,
          .seed = 7};
}

TEST(BreathingPattern, ARegularOneIsLujansFormula) {
  const BreathingPattern pattern({.period_s = 4.0, .exponent = 2});
  for (double t = 0.05; t < 20.0; t += 0.173) {
    const double cosine = std::cos(std::numbers::pi * t / 4.0);
    const Breath breath = pattern.At(t);
    EXPECT_NEAR(breath.level, std::pow(cosine, 4), 1e-12);
    EXPECT_NEAR(breath.cycle, t / 4.0 - std::floor(t / 4.0), 1e-12);
  }
}

TEST(BreathingPattern, TheRateIsTheDerivativeOfTheLevelAndHasNoStep) {
  const BreathingPattern pattern(Irregular());
  constexpr double kStepS = 1e-4;
  double before = pattern.At(0.2).level_per_s;
  for (double t = 0.2; t < 40.0; t += kStepS) {
    const Breath breath = pattern.At(t);
    const double slope = (pattern.At(t + 1e-6).level - pattern.At(t - 1e-6).level) / 2e-6;
    ASSERT_NEAR(breath.level_per_s, slope, 1e-3) << t;
    ASSERT_LT(std::abs(breath.level_per_s - before), 0.02) << t;
    ASSERT_GE(breath.cycle, 0.0);
    ASSERT_LT(breath.cycle, 1.0);
    before = breath.level_per_s;
  }
}

TEST(BreathingPattern, SpreadsAsFarAsRequested) {
  const BreathingPattern pattern(Irregular());
  std::vector<double> starts_s;
  double last = 0.9;
  for (double t = 0.001; t < 3600.0; t += 0.01) {
    const double cycle = pattern.At(t).cycle;
    if (cycle < last) starts_s.push_back(t);
    last = cycle;
  }
  double sum = 0.0;
  double squares = 0.0;
  const auto count = static_cast<double>(starts_s.size() - 1);
  for (std::size_t n = 1; n < starts_s.size(); ++n) {
    const double period_s = starts_s[n] - starts_s[n - 1];
    sum += period_s;
    squares += period_s * period_s;
  }
  const double mean_s = sum / count;
  EXPECT_NEAR(mean_s, 3.7, 0.06);
  EXPECT_NEAR(std::sqrt(squares / count - mean_s * mean_s), 0.15 * 3.7, 0.05);
}

TEST(BreathingPattern, IsTheSameForTheSameSeedOnly) {
  PatternSettings other = Irregular();
  const BreathingPattern a(other);
  const BreathingPattern b(other);
  other.seed = 8;
  const BreathingPattern c(other);
  EXPECT_EQ(a.At(123.4).level, b.At(123.4).level);
  EXPECT_NE(a.At(123.4).level, c.At(123.4).level);
}

TEST(BreathingPattern, HoldsBeforeTheBeginningAndAfterADay) {
  const BreathingPattern pattern({});
  for (const double t : {-5.0, 0.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(pattern.At(t).level, 1.0) << t;
    EXPECT_EQ(pattern.At(t).level_per_s, 0.0) << t;
  }
}

TEST(BreathingPattern, RefusesSettingsOutOfRange) {
  EXPECT_THROW(BreathingPattern({.period_s = 0.4}), InputError);
  EXPECT_THROW(BreathingPattern({.period_s = 61}), InputError);
  EXPECT_THROW(BreathingPattern({.exponent = 0}), InputError);
  EXPECT_THROW(BreathingPattern({.exponent = 9}), InputError);
  EXPECT_THROW(BreathingPattern({.period_spread = -0.1}), InputError);
  EXPECT_THROW(BreathingPattern({.period_spread = 0.4}), InputError);
  EXPECT_THROW(BreathingPattern({.speed_spread = 0.9}), InputError);
  EXPECT_THROW(BreathingPattern({.level_spread = 0.4}), InputError);
  EXPECT_THROW(BreathingPattern({.level = 6}), InputError);
  EXPECT_THROW(BreathingPattern({.level = -1}), InputError);
}

}  // namespace
}  // namespace acus::breathing
