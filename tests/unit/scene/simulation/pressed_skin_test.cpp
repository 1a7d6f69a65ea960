#include "acus/scene/simulation/pressed_skin.h"

#include <cmath>
#include <gtest/gtest.h>

#include "support/layered_scene.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;

/// Looks along +z, its face `depth_mm` in the skin of the layered scene, which is at z = 0.
Eigen::Isometry3d PressedBy(double depth_mm) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  pose.translation() = Vector3d(0.0, 0.0, depth_mm);
  return pose;
}

class PressedSkinTest : public testing::Test {
 protected:
  const Scene scene_ =
      testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
  const forces::TissueLookup tissue_{*scene_.labels};
  const tissue::ProbeFace face_{.length_mm = 40.0};
};

TEST_F(PressedSkinTest, TheSkinLiesOnTheFaceAndDeepTissueStays) {
  const PressedSkin pressed(face_, PressedBy(6.0), tissue_, nullptr, 2.0);
  ASSERT_TRUE(pressed.presses());
  EXPECT_NEAR(pressed.DepthMm(0.0), 6.0, 0.01);
  const auto rest_z = [&](const Vector3d& place) { return pressed.RestInCtMm(place, place).z(); };
  EXPECT_NEAR(rest_z({5.0, 0.0, 6.0}), 0.0, 0.02);
  // Half way down to the face's length of 40 mm it is half, by 1 - 3 t^2 + 2 t^3.
  EXPECT_NEAR(rest_z({5.0, 0.0, 23.0}), 20.0, 0.02);
  const Vector3d deep(3.0, 0.0, 60.0);
  EXPECT_EQ(pressed.RestInCtMm(deep, deep), deep);
  const Vector3d beside(36.0, 0.0, 10.0);
  EXPECT_EQ(pressed.RestInCtMm(beside, beside), beside);
  double before = rest_z({0.0, 0.0, -5.0});
  for (double z = -4.9; z < 60.0; z += 0.1) {  // One to one.
    const double now = rest_z({0.0, 0.0, z});
    EXPECT_GT(now, before);
    EXPECT_LT(now - before, 0.25);
    before = now;
  }
}

TEST_F(PressedSkinTest, InAirOrTooDeepNothingMovesByABit) {
  for (const double depth_mm : {-3.0, 45.0}) {
    const PressedSkin pressed(face_, PressedBy(depth_mm), tissue_, nullptr, 2.0);
    EXPECT_FALSE(pressed.presses());
    const Vector3d place(1.0 / 3.0, 2.0, 17.1);
    EXPECT_EQ(pressed.RestInCtMm(place, place), place);
  }
}

TEST_F(PressedSkinTest, AConvexFacePressesDeepestInItsMiddle) {
  const PressedSkin pressed({.length_mm = 40.0, .radius_mm = 50.0}, PressedBy(5.0), tissue_,
                            nullptr, 2.0);
  EXPECT_NEAR(pressed.DepthMm(0.0), 5.0, 0.01);
  EXPECT_NEAR(pressed.DepthMm(15.0), 5.0 - (50.0 - std::sqrt(2500.0 - 225.0)), 0.3);
}

}  // namespace
}  // namespace acus::simulation
