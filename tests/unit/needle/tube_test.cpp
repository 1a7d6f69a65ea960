#include "needle/tube.h"

#include <gtest/gtest.h>
#include <numbers>

namespace acus::needle {
namespace {

TEST(Tube, HasTheStiffnessOfARingAndOfAFullRound) {
  const Tube ring{2.0, 1.0, 200e3, 0.25};
  EXPECT_NEAR(ring.SecondMomentMm4(), std::numbers::pi / 64.0 * 15.0, 1e-12);
  EXPECT_NEAR(ring.BendingStiffnessNMm2(), 200e3 * std::numbers::pi / 64.0 * 15.0, 1e-6);
  // G J = E / (2 (1 + nu)) * 2 I.
  EXPECT_NEAR(ring.TwistStiffnessNMm2() / ring.BendingStiffnessNMm2(), 0.8, 1e-12);
  const Tube round{2.0, 0.0, 200e3, 0.25};
  EXPECT_NEAR(round.SecondMomentMm4(), std::numbers::pi / 4.0, 1e-12);
}

}  // namespace
}  // namespace acus::needle
