#include "acus/scene/simulation/pressed_by_proxies.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;

/// Tissue in z > 0, or in a ball below.
class Body : public forces::HuField {
 public:
  explicit Body(double ball_radius_mm = 0.0) : radius_mm_(ball_radius_mm) {}
  double HuAt(const Vector3d& p) const noexcept override {
    return radius_mm_ > 0.0 ? radius_mm_ - (p - Vector3d(0, 0, radius_mm_)).norm() : p.z();
  }
  double ResolutionMm() const noexcept override { return 1.0; }

 private:
  double radius_mm_;
};

/// Points along +z, its origin `depth_mm` under the skin, which is at z = 0.
Eigen::Isometry3d Pointing(double depth_mm) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  pose.translation() = Vector3d(0.0, 0.0, depth_mm);
  return pose;
}

Vector3d RestOf(const PressedByProxies& pressed, const Vector3d& place) {
  return pressed.RestInCtMm(place, place);
}

TEST(PressedByProxies, TheSkinLiesOnAFlatFace) {
  const Body body;
  const auto tool = forces::ProbeFaceNodes(40.0, 12.0, 0.0, 16);
  const PressedByProxies pressed(tool, Pointing(6.0), body, 0.0, nullptr, 2.0);
  ASSERT_TRUE(pressed.presses());
  for (double x = -16.0; x <= 16.0; x += 1.0) {
    for (double y = -4.0; y <= 4.0; y += 1.0) {
      EXPECT_NEAR(RestOf(pressed, {x, y, 6.0}).z(), 0.0, 1e-3) << x << ", " << y;
    }
  }
  // A quarter of a millimetre less for each millimetre below.
  EXPECT_NEAR(RestOf(pressed, {0.0, 0.0, 14.0}).z(), 14.0 - (6.0 - 0.25 * 8.0), 1e-3);
  for (const Vector3d& place : {Vector3d(0, 0, 30.5), Vector3d(0, 30, 6), Vector3d(40, 0, 8)}) {
    EXPECT_EQ(RestOf(pressed, place), place) << "out of reach, by no bit";
  }
}

TEST(PressedByProxies, AFingertipIsNeverInTheTissueThatIsShown) {
  const Body body;
  const auto tool = forces::FingertipNodes(8.0, 32);
  const Eigen::Isometry3d pose = Pointing(5.0);
  const PressedByProxies pressed(tool, pose, body, 0.0, nullptr, 2.0);
  int in_skin = 0;
  for (int i = 0; i < tool.num_nodes; ++i) {
    const Vector3d at = pose * tool.node_mm[static_cast<std::size_t>(i)];
    if (at.z() <= 0.0) continue;
    ++in_skin;
    const double rest_mm = RestOf(pressed, at).z();
    EXPECT_LT(rest_mm, 1e-3) << "tissue in the finger";
    EXPECT_GT(rest_mm, -4.0) << "a gap beside the finger";
  }
  EXPECT_GT(in_skin, 5);
  EXPECT_NEAR(RestOf(pressed, pose * Vector3d::Zero()).z(), 0.0, 0.6);
}

TEST(PressedByProxies, DoesNotFold) {
  // Tilted fingers and faces in a ball, in random places of it: along the axis the map rises by
  // 0.75 to 1.25, and it moves along the axis alone.
  const Body ball(60.0);
  for (int n = 0; n < 40; ++n) {
    RandomStream random(4, "palpation", static_cast<std::uint64_t>(n));
    const auto tool =
        n % 2 == 0 ? forces::FingertipNodes(8.0, 16) : forces::ProbeFaceNodes(40.0, 12.0, 60.0, 25);
    const Eigen::Isometry3d pose = Pointing(random.Uniform(1.0, 15.0)) *
                                   Eigen::AngleAxisd(random.Uniform(-0.5, 0.5), Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(random.Uniform(-0.5, 0.5), Vector3d::UnitX());
    const PressedByProxies pressed(tool, pose, ball, 0.0, nullptr, 2.0);
    ASSERT_TRUE(pressed.presses());
    const Vector3d axis = pose.linear().col(1);
    for (int i = 0; i < 500; ++i) {
      const Vector3d place = pose * Vector3d(random.Uniform(-30, 30), random.Uniform(-20, 60),
                                             random.Uniform(-20, 20));
      const Vector3d moved = place - RestOf(pressed, place);
      EXPECT_LT(moved.cross(axis).norm(), 1e-9);
      EXPECT_GE(moved.dot(axis), 0.0);
      const double step_mm = random.Uniform(0.01, 5.0);
      const double rise =
          (RestOf(pressed, place + step_mm * axis) - RestOf(pressed, place)).dot(axis) / step_mm;
      EXPECT_GT(rise, 0.75 - 1e-9);
      EXPECT_LT(rise, 1.25 + 1e-9);
    }
  }
}

TEST(PressedByProxies, InAirTooDeepOrWithoutAPoseNothingMovesByABit) {
  const Body body;
  const auto tool = forces::FingertipNodes(8.0, 16);
  Eigen::Isometry3d lost = Pointing(5.0);
  lost.translation().x() = NAN;
  for (const Eigen::Isometry3d& pose : {Pointing(-1.0), Pointing(60.0), lost}) {
    const PressedByProxies pressed(tool, pose, body, 0.0, nullptr, 2.0);
    EXPECT_FALSE(pressed.presses());
    const Vector3d place(1.0 / 3.0, 2.0, 17.1);
    EXPECT_EQ(RestOf(pressed, place), place);
  }
}

/// All tissue 7 mm along z, as breath might move it.
class Shifted : public slicing::RestMap {
 public:
  Vector3d RestInCtMm(const Vector3d& place, const Vector3d&) const noexcept override {
    return place - Vector3d(0, 0, 7.0);
  }
  double SpacingMm() const noexcept override { return 3.0; }
};

TEST(PressedByProxies, PressesTheTissueThatBreathMoved) {
  const Body body;
  const Shifted breath;
  const auto tool = forces::ProbeFaceNodes(40.0, 12.0, 0.0, 16);
  const PressedByProxies pressed(tool, Pointing(10.0), body, 0.0, &breath, 2.0);
  ASSERT_TRUE(pressed.presses());
  EXPECT_NEAR(pressed.DepthMm({0, 0, 10.0}), 3.0, 1e-3) << "the skin is at 7 mm now";
  EXPECT_NEAR(RestOf(pressed, {0, 0, 10.0}).z(), 0.0, 1e-3);
  EXPECT_EQ(pressed.SpacingMm(), 2.0);
}

}  // namespace
}  // namespace acus::simulation
