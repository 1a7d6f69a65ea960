#include "acus/physics/needle/tube.h"

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

// Fortmeier-2016 section 2.3 measured a 16G, 150 mm needle: 12.5 mm at 0.5 N and 26 mm at 1 N.
TEST(Tube, BendsAsTheMeasuredSixteenGaugeNeedle) {
  const Tube needle{1.65, 1.19, 193e3};
  EXPECT_NEAR(0.5 / needle.EndStiffnessNPerMm(150.0), 12.5, 0.2 * 12.5);
}

}  // namespace
}  // namespace acus::needle
