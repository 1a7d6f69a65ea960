#include "acus/physics/breathing/tool_at_rest.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "support/breathing_box.h"

namespace acus::breathing {
namespace {

using testing_support::RegularBreath;

MotionModel Box() {
  return BuildModel(MotionKind::kSurrogate, testing_support::TruePhases(8));
}

Eigen::Isometry3d Pose(const Eigen::Vector3d& place_mm) {
  return Eigen::Translation3d(place_mm) *
         Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 0.3, 0.2).normalized());
}

TEST(ToolAtRest, FollowsABreathingPatientAtAKilohertz) {
  const MotionModel model = Box();
  ToolTrack track;
  double worst_mm = 0.0;
  for (int n = 0; n < 8000; ++n) {
    const MotionMap map(model.field(), model.WeightsAt(RegularBreath(n / 4000.0)));
    const Eigen::Isometry3d pose = Pose({5.0 + 1e-3 * n, -10.0, 60.0});
    const ToolAtRest at_rest = AtRest(map, pose, Eigen::Vector3d::UnitZ(), track);
    const Eigen::Vector3d back = map.WorldMm(at_rest.ct_from_tool.translation());
    worst_mm = std::max(worst_mm, (back - pose.translation()).norm());
  }
  EXPECT_LT(worst_mm, 0.05);
}

TEST(ToolAtRest, TurnsItsAxisAndForcesAsTheTissueIsTurned) {
  const MotionModel model = Box();
  const MotionMap map(model.field(), model.WeightsAt(RegularBreath(0.5)));
  ToolTrack track;
  const Eigen::Isometry3d pose = Pose({20, 0, 50});
  const ToolAtRest at_rest = AtRest(map, pose, Eigen::Vector3d::UnitZ(), track);
  const Eigen::Vector3d rest = at_rest.ct_from_tool.translation();
  const Eigen::Vector3d rest_axis = at_rest.ct_from_tool.linear().col(2);
  const Eigen::Vector3d moved = map.WorldMm(rest + rest_axis) - map.WorldMm(rest - rest_axis);
  const Eigen::Vector3d axis = pose.linear().col(2);
  EXPECT_LT(moved.normalized().cross(axis).norm(), 1e-4);
  EXPECT_LT((at_rest.world_from_rest * rest_axis - axis).norm(), 1e-12);
  EXPECT_GT((rest_axis - axis).norm(), 1e-3);
}

TEST(ToolAtRest, IsThePoseItselfBitForBitWhereNothingMoves) {
  const MotionModel model = Box();
  const MotionMap map(model.field(), model.WeightsAt(RegularBreath(0.3), 0.0));
  ToolTrack track;
  const Eigen::Isometry3d pose = Pose({1.0 / 3.0, 0, 50});
  const ToolAtRest at_rest = AtRest(map, pose, Eigen::Vector3d::UnitZ(), track);
  EXPECT_EQ(at_rest.ct_from_tool.matrix(), pose.matrix());
  EXPECT_EQ(at_rest.world_from_rest.coeffs(), Eigen::Quaterniond::Identity().coeffs());
}

TEST(ToolAtRest, ComesBackFromJumpsAndRubbish) {
  const MotionModel model = Box();
  const MotionMap map(model.field(), model.WeightsAt(RegularBreath(0.45)));
  ToolTrack track;
  AtRest(map, Pose({0, 0, 50}), Eigen::Vector3d::UnitZ(), track);
  const ToolAtRest jumped = AtRest(map, Pose({50, -40, 80}), Eigen::Vector3d::UnitZ(), track);
  EXPECT_LT(jumped.residual_mm, 0.02);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AtRest(map, Pose({nan, 0, 50}), Eigen::Vector3d::UnitZ(), track);
  const ToolAtRest after = AtRest(map, Pose({0, 0, 50}), Eigen::Vector3d::UnitZ(), track);
  EXPECT_TRUE(after.ct_from_tool.matrix().allFinite());
  EXPECT_LT(after.residual_mm, 0.02);
}

}  // namespace
}  // namespace acus::breathing
