#include "acus/scene/effects/pulsating_vessels/pulse.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

TEST(Pulse, RisesInSystoleAndRunsOff) {
  const Pulse pulse(60.0, 0.2);
  EXPECT_EQ(pulse.At(0.0), 0.0);
  EXPECT_NEAR(pulse.At(0.1), 0.5, 1e-12);
  EXPECT_NEAR(pulse.At(0.2), 1.0, 1e-12);
  const double end = std::exp(-3.0);
  EXPECT_NEAR(pulse.At(0.6), (std::exp(-1.5) - end) / (1.0 - end), 1e-12);
  EXPECT_NEAR(pulse.At(1.0 - 1e-9), 0.0, 1e-8);
}

TEST(Pulse, RepeatsWithTheHeartAlsoBeforeTheSession) {
  const Pulse pulse(75.0, 0.15);
  EXPECT_NEAR(pulse.period_s(), 0.8, 1e-12);
  for (const double s : {-0.3, 0.05, 0.31}) {
    EXPECT_NEAR(pulse.At(s), pulse.At(s + 8.0), 1e-9);
  }
  EXPECT_EQ(pulse.At(std::numeric_limits<double>::quiet_NaN()), 0.0);
  EXPECT_EQ(pulse.At(std::numeric_limits<double>::infinity()), 0.0);
}

TEST(Pulse, RefusesWhatIsNoHeart) {
  EXPECT_THROW(Pulse(0.0, 0.2), InputError);
  EXPECT_THROW(Pulse(301.0, 0.2), InputError);
  EXPECT_THROW(Pulse(60.0, 1.0), InputError);
}

}  // namespace
}  // namespace acus::effects
