#include "acus/scene/effects/pain_reaction/jerk.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

const Jerk kJerk(0.15, 0.25, 1.5);

TEST(Jerk, BeginsAfterItsLatencyAndEndsAtRest) {
  EXPECT_EQ(kJerk.DurationS(), 0.15 + 0.25 + 1.5);
  for (const double since_s : {-1.0, 0.0, 0.15, 1.9, 1e9}) {
    EXPECT_EQ(kJerk.At(since_s), 0.0) << since_s;
  }
  EXPECT_EQ(kJerk.At(std::numeric_limits<double>::quiet_NaN()), 0.0);
  EXPECT_EQ(kJerk.At(std::numeric_limits<double>::infinity()), 0.0);
  EXPECT_NEAR(kJerk.At(0.40), 1.0, 1e-12);
  EXPECT_NEAR(kJerk.At(0.15 + 0.125), 0.5, 1e-12) << "half-way at half the time";
  EXPECT_NEAR(kJerk.At(0.40 + 0.75), 0.5, 1e-12);
}

// Velocity and acceleration have no step: the largest of a minimum-jerk movement of duration T are
// 1.875 / T and 5.7735 / T^2 (Flash and Hogan 1985).
TEST(Jerk, IsSmooth) {
  constexpr double kStepS = 1e-4;
  double fastest = 0.0;
  double hardest = 0.0;
  for (double t = 0.1; t < 2.0; t += kStepS) {
    const double before = kJerk.At(t - kStepS);
    const double now = kJerk.At(t);
    const double after = kJerk.At(t + kStepS);
    fastest = std::max(fastest, std::abs(after - before) / (2.0 * kStepS));
    hardest = std::max(hardest, std::abs(after - 2.0 * now + before) / (kStepS * kStepS));
  }
  EXPECT_NEAR(fastest, 1.875 / 0.25, 1e-3);
  EXPECT_NEAR(hardest, 10.0 / std::sqrt(3.0) / (0.25 * 0.25), 0.1);
}

TEST(Jerk, MayBeginAtOnce) {
  const Jerk at_once(0.0, 0.25, 1.5);
  EXPECT_EQ(at_once.DurationS(), 1.75);
  EXPECT_NEAR(at_once.At(0.125), 0.5, 1e-12);
}

TEST(Jerk, RefusesDurationsThatAreNone) {
  EXPECT_THROW(Jerk(-0.1, 0.2, 1.0), InputError);
  EXPECT_THROW(Jerk(0.1, 0.0, 1.0), InputError);
  EXPECT_THROW(Jerk(0.1, 0.2, 0.0), InputError);
  EXPECT_THROW(Jerk(0.1, 0.2, std::numeric_limits<double>::infinity()), InputError);
}

}  // namespace
}  // namespace acus::effects
