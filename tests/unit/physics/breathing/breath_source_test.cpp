#include "acus/physics/breathing/breath_source.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

TEST(BreathClock, StandsStillWhileBreathIsHeldAndNeverJumps) {
  const BreathClock clock({{2.0, 5.0}, {8.0, 10.0}});
  EXPECT_EQ(clock.At(1.5).time_s, 1.5);
  EXPECT_NEAR(clock.At(2.5).time_s, 2.25, 1e-12);
  EXPECT_EQ(clock.At(3.0).speed, 0.0);
  EXPECT_NEAR(clock.At(4.4).time_s, 2.25, 1e-12);
  EXPECT_NEAR(clock.At(5.0).time_s, 2.5, 1e-12);  // Three seconds, of which a ramp's worth passed.
  EXPECT_NEAR(clock.At(20.0).time_s, 20.0 - 2.5 - 1.5, 1e-12);
  BreathClock::Moment before = clock.At(0.0);
  for (double t = 1e-4; t < 12.0; t += 1e-4) {
    const BreathClock::Moment now = clock.At(t);
    ASSERT_NEAR((now.time_s - before.time_s) / 1e-4, now.speed, 1e-3) << t;
    ASSERT_LT(std::abs(now.speed - before.speed), 3e-4) << t;
    before = now;
  }
}

TEST(BreathSource, HoldsTheLevelAndSaysThatItDoesNotChange) {
  const BreathSource source(BreathingPattern({.period_s = 4.0}), {{0.8, 4.0}});
  EXPECT_EQ(source.At(2.0).level, source.At(3.4).level);
  EXPECT_EQ(source.At(2.0).level_per_s, 0.0);
  EXPECT_GT(source.At(2.0).level, 0.0);
  const BreathSource free(BreathingPattern({.period_s = 4.0}), {});
  EXPECT_NEAR(source.At(10.0).level, free.At(10.0 - 2.7).level, 1e-12);
}

TEST(BreathClock, RefusesHoldsThatOverlapOrAreTooShort) {
  EXPECT_THROW(BreathClock({{2.0, 2.9}}), InputError);
  EXPECT_THROW(BreathClock({{2.0, 4.0}, {3.9, 6.0}}), InputError);
  EXPECT_THROW(BreathClock({{std::nan(""), 4.0}}), InputError);
}

}  // namespace
}  // namespace acus::breathing
