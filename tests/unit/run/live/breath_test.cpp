// The breath of a live session: held on command, or followed on a belt.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/physics/breathing/breath_source.h"
#include "acus/run/live/live_breath.h"
#include "support/breathing_box.h"

namespace acus::live {
namespace {

using session::BreathStatus;

constexpr double kStepS = 0.001;

simulation::Breathing Partner() {
  return {.motion = {.name = "box",
                     .model = breathing::MotionModel::Sinusoid(
                         breathing::MotionField(testing_support::BreathingNodes(), 1), 1.0)},
          .source = {breathing::BreathingPattern({.period_s = 4.0, .exponent = 1}), {}},
          .from_session = true};
}

TEST(LiveBreath, HeldOnCommandIsTheBreathOfAClockThatKnewOfIt) {
  const simulation::Breathing partner = Partner();
  LiveBreath breath(partner, false);
  const breathing::BreathSource known(breathing::BreathingPattern({.period_s = 4.0, .exponent = 1}),
                                      {{2.0, 5.0}});
  // A hold of the scenario ends with the ramp, one on command begins it then.
  for (int i = 0; i <= 8000; ++i) {
    const double time_s = i * kStepS;
    if (i == 2001) breath.Hold(true);
    if (i == 4501) breath.Hold(false);
    const session::BreathSample sample = breath.Step(time_s);
    const breathing::Breath expected = known.At(time_s);
    ASSERT_NEAR(sample.level, expected.level, 1e-9) << time_s;
    ASSERT_NEAR(sample.level_per_s, expected.level_per_s, 1e-9) << time_s;
    ASSERT_NEAR(sample.cycle, expected.cycle, 1e-9) << time_s;
    const bool held = i >= 2001 && i < 5000;
    ASSERT_EQ(sample.status == BreathStatus::kHeld, held) << time_s;
  }
}

TEST(LiveBreath, ReleasedBeforeItStandsStillItTurnsBackWithoutAJump) {
  const simulation::Breathing partner = Partner();
  LiveBreath breath(partner, false);
  double last_level = breath.Step(0.0).level;
  double last_rate = 0.0;
  for (int i = 1; i < 4000; ++i) {
    breath.Hold(i % 400 < 150);
    const session::BreathSample sample = breath.Step(i * kStepS);
    ASSERT_LT(std::abs(sample.level - last_level), 1e-3);
    ASSERT_LT(std::abs(sample.level_per_s - last_rate), 4e-3);
    last_level = sample.level;
    last_rate = sample.level_per_s;
  }
}

double BeltLevel(double time_s) {
  return 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * time_s / 4.0);
}

TEST(BeltFollower, FollowsABreathBetweenReadings) {
  BeltFollower belt;
  double worst = 0.0, worst_rate = 0.0;
  for (int i = 0; i < 12000; ++i) {
    const double time_s = i * kStepS;
    if (i % 33 == 0) belt.Read(time_s, BeltLevel(time_s));
    if (i < 2000) continue;
    const breathing::Breath breath = belt.At(time_s);
    const double rate = -0.25 * std::numbers::pi * std::sin(0.5 * std::numbers::pi * time_s);
    worst = std::max(worst, std::abs(breath.level - BeltLevel(time_s)));
    worst_rate = std::max(worst_rate, std::abs(breath.level_per_s - rate));
    ASSERT_EQ(belt.StatusAt(time_s), BreathStatus::kBreathing);
    ASSERT_TRUE(breath.cycle >= 0.0 && breath.cycle < 1.0);
    if (std::abs(rate) > 0.4) {
      EXPECT_NEAR(breath.cycle, std::fmod(time_s / 4.0, 1.0), 0.05) << time_s;
    }
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(worst_rate, 0.3);
}

TEST(BeltFollower, AGapIsBridgedThenHeldAndReported) {
  BeltFollower belt;
  EXPECT_EQ(belt.StatusAt(0.0), BreathStatus::kLost);
  double time_s = 0.0;
  for (; time_s < 5.0; time_s += 0.03) belt.Read(time_s, BeltLevel(time_s));
  const double last_s = time_s - 0.03;
  const double level = belt.At(last_s).level;
  const double rate = belt.At(last_s).level_per_s;
  EXPECT_EQ(belt.StatusAt(last_s + 0.2), BreathStatus::kPredicted);
  EXPECT_NEAR(belt.At(last_s + 0.2).level, level + 0.2 * rate, 1e-12);
  EXPECT_EQ(belt.StatusAt(last_s + 0.9), BreathStatus::kLost);
  const breathing::Breath held = belt.At(last_s + 0.9);
  EXPECT_EQ(held.level_per_s, 0.0);
  EXPECT_NEAR(held.level, level + rate * (0.3 + 0.25), 1e-12);
  EXPECT_EQ(belt.At(last_s + 500.0).level, held.level);
  belt.Read(last_s + 10.0, 0.5);  // Back.
  EXPECT_EQ(belt.StatusAt(last_s + 10.01), BreathStatus::kBreathing);
  EXPECT_EQ(belt.At(last_s + 10.0).level, 0.5);
}

TEST(BeltFollower, LeavesOutWhatIsNoReading) {
  BeltFollower belt;
  belt.Read(1.0, 0.5);
  for (const double bad : {std::nan(""), HUGE_VAL, 11.0, -11.0}) belt.Read(1.1, bad);
  belt.Read(1.0, 0.9);
  belt.Read(0.5, 0.9);
  belt.Read(std::nan(""), 0.9);
  EXPECT_EQ(belt.num_readings(), 1);
  EXPECT_EQ(belt.num_rejected(), 7);
  EXPECT_EQ(belt.At(1.0).level, 0.5);
}

TEST(LiveBreath, HeldWithABeltItStaysAndComesBackToTheBeltSmoothly) {
  const simulation::Breathing partner = Partner();
  LiveBreath breath(partner, true);
  double last = 0.0, held_at = 0.0;
  for (int i = 0; i < 12000; ++i) {
    const double time_s = i * kStepS;
    if (i % 33 == 0) breath.ReadBelt(time_s, BeltLevel(time_s));
    if (i == 3000) breath.Hold(true);
    if (i == 6000) breath.Hold(false);
    const session::BreathSample sample = breath.Step(time_s);
    if (i == 3600) held_at = sample.level;
    if (i > 3600 && i < 6000) {
      ASSERT_EQ(sample.level, held_at) << time_s;
    }
    if (i > 0) {
      ASSERT_LT(std::abs(sample.level - last), 0.02) << time_s;
    }
    if (i > 10000) {
      ASSERT_NEAR(sample.level, BeltLevel(time_s), 0.03) << time_s;
    }
    last = sample.level;
  }
}

}  // namespace
}  // namespace acus::live
