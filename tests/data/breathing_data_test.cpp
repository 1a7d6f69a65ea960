// Real surrogates of breathing: a belt at 1 kHz, and two signals without times.
#include <gtest/gtest.h>

#include "acus/physics/breathing/recorded_breath.h"
#include "support/shared_data.h"

namespace acus::breathing {
namespace {

TEST(BreathingData, ABeltAtOneKilohertz) {
  const auto path = testing_support::SharedData("breathing/respiration_1khz.txt");
  if (!path) GTEST_SKIP() << "test data breathing/respiration_1khz.txt is not here";
  const RecordedBreath breath(ReadBreathSignal(*path, {}), {});
  EXPECT_NEAR(breath.duration_s(), 60.0, 10.0);
  const double per_minute = 60.0 * breath.num_breaths() / breath.duration_s();
  EXPECT_GT(per_minute, 6.0);
  EXPECT_LT(per_minute, 30.0);
  EXPECT_GT(breath.inspiration_level(), breath.expiration_level());
}

TEST(BreathingData, TwoSignalsWithoutTimes) {
  const auto path = testing_support::SharedData("breathing/surrogate_two_signals.txt");
  if (!path) GTEST_SKIP() << "test data breathing/surrogate_two_signals.txt is not here";
  for (const char* column : {"0", "1"}) {
    const BreathSignal signal = ReadBreathSignal(*path, {.column = column, .rate_hz = 5.0});
    EXPECT_EQ(signal.level.size(), 355U);
    const RecordedBreath breath(signal, {.smoothing_s = 0.3});
    EXPECT_GE(breath.num_breaths(), 5) << column;
  }
}

}  // namespace
}  // namespace acus::breathing
