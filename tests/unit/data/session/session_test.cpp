#include "acus/data/session/session.h"

#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/math/rigid.h"

namespace acus::session {
namespace {

transforms::Pose Turned(double angle, double x_mm) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  pose.translation().x() = x_mm;
  return pose;
}

TEST(PoseAt, IsLinearInPlaceAndAngleBetweenSamples) {
  const PoseStream stream = {{1'000, Turned(0.0, 10.0), true}, {5'000, Turned(1.0, 30.0), true}};
  const PoseSample at = PoseAt(stream, 2'000);
  EXPECT_EQ(at.time_ns, 2'000);
  EXPECT_TRUE(at.valid);
  EXPECT_LT((at.reference_from_tool.matrix() - Turned(0.25, 15.0).matrix()).norm(), 1e-14);
}

TEST(PoseAt, TurnsTheShorterDirection) {
  const double pi = std::numbers::pi;
  const PoseStream stream = {{0, Turned(0.9 * pi, 0.0), true}, {2, Turned(-0.9 * pi, 0.0), true}};
  EXPECT_NEAR(math::AngleBetweenRad(PoseAt(stream, 1).reference_from_tool, Turned(pi, 0.0)), 0.0,
              1e-7);
}

TEST(PoseAt, HoldsTheEndsAndGivesSamplesThemselves) {
  const PoseStream stream = {{10, Turned(0.3, 1.0), true}, {20, Turned(0.7, 2.0), true}};
  EXPECT_EQ(PoseAt(stream, 0).reference_from_tool, stream[0].reference_from_tool);
  EXPECT_EQ(PoseAt(stream, 99).reference_from_tool, stream[1].reference_from_tool);
  EXPECT_EQ(PoseAt(stream, 20).reference_from_tool, stream[1].reference_from_tool);
}

TEST(PoseAt, IsValidOnlyBetweenValidSamples) {
  const PoseStream stream = {{0, {}, true}, {10, {}, false}, {20, {}, true}, {30, {}, true}};
  EXPECT_FALSE(PoseAt(stream, 5).valid);
  EXPECT_FALSE(PoseAt(stream, 15).valid);
  EXPECT_TRUE(PoseAt(stream, 25).valid);
  EXPECT_FALSE(PoseAt(stream, 10).valid);
  EXPECT_TRUE(PoseAt(stream, 20).valid);  // A reading itself, whatever was before it.
}

}  // namespace
}  // namespace acus::session
