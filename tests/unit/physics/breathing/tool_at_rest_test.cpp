#include "acus/physics/breathing/tool_at_rest.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "support/breathing_box.h"
#include "support/breathing_patients.h"

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

// Line 7 of algorithm 1: X+ = x + u(X). The tissue that is at x was at x - u, so the tool is 2 u
// off.
TEST(ToolAtRest, AsPrintedItAddsTheMotion) {
  const MotionModel model = Box();
  const MotionMap map(model.field(), model.WeightsAt(RegularBreath(0.5)));
  ToolTrack track;
  const Eigen::Isometry3d pose = Pose({20, 0, 50});
  const auto place_mm = [&] {
    return Eigen::Vector3d(
        AtRest(map, pose, Eigen::Vector3d::UnitZ(), track, true).ct_from_tool.translation());
  };
  const Eigen::Vector3d x_mm = pose.translation();
  const Eigen::Vector3d first_mm = place_mm();
  EXPECT_EQ(first_mm, x_mm + map.DisplacementMm(x_mm));
  EXPECT_EQ(place_mm(), x_mm + map.DisplacementMm(first_mm));
  for (int n = 0; n < 30; ++n) place_mm();
  ToolTrack inverse;
  const Eigen::Vector3d rest_mm =
      AtRest(map, pose, Eigen::Vector3d::UnitZ(), inverse).ct_from_tool.translation();
  const double moved_mm = map.DisplacementMm(rest_mm).norm();
  ASSERT_GT(moved_mm, 3.0);
  EXPECT_NEAR((place_mm() - rest_mm).norm(), 2.0 * moved_mm, 0.3 * moved_mm);
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

TEST(ToolAtRest, ComesBackFromJumpsAndInvalidData) {
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

/// Of a hand that moves and turns a little, in breath that is held: the work of what it feels, and
/// of what acts on the tool at rest, from finite differences of where the tool lies then.
struct Works {
  double world = 0.0;
  double rest = 0.0;
};
Works WorksOf(const MotionMap& map, const Eigen::Isometry3d& pose, const Eigen::Vector3d& axis,
              const Eigen::Vector3d& rest_force, const Eigen::Vector3d& rest_torque,
              const Eigen::Vector3d& move_mm, const Eigen::Vector3d& turn_rad) {
  const auto laid = [&](double sign) {
    Eigen::Isometry3d moved = pose;
    moved.translation() += sign * 0.5 * move_mm;
    const Eigen::Vector3d turn = sign * 0.5 * turn_rad;
    if (turn.norm() > 0.0) {
      moved.linear() =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * pose.linear();
    }
    ToolTrack track;
    for (int i = 0; i < 4; ++i) AtRest(map, moved, axis, track);
    return AtRest(map, moved, axis, track).ct_from_tool;
  };
  const Eigen::Isometry3d before = laid(-1.0);
  const Eigen::Isometry3d after = laid(1.0);
  const Eigen::AngleAxisd turned(Eigen::Matrix3d(after.linear() * before.linear().transpose()));
  Eigen::Vector3d force = rest_force;
  Eigen::Vector3d torque = rest_torque;
  ToolTrack track;
  CarryToWorld(map, AtRest(map, pose, axis, track), force, torque);
  return {force.dot(move_mm) + torque.dot(turn_rad),
          rest_force.dot(after.translation() - before.translation()) +
              rest_torque.dot(turned.angle() * turned.axis())};
}

TEST(CarriedForces, DoTheWorkThatTheyDoAtRest) {
  using Eigen::Vector3d;
  testing_support::BreathingPatient patient{.kind = MotionKind::kSinusoid, .nodes_per_axis = 201};
  patient.box.size.setConstant(201);
  patient.largest_mm = 30.0;  // Strain to 0.47.
  const MotionModel model = patient.Model();
  const MotionMap map(model.field(), model.WeightsAt({.level = 0.0}));
  double worst = 0.0;
  double most_rotated = 0.0;  // How far a rotation is from it.
  for (int n = 0; n < 200; ++n) {
    const auto in = [n](double from, double to, double step) {
      return from + (to - from) * (0.5 + 0.5 * std::sin(step * (n + 1)));
    };
    const Eigen::Isometry3d pose =
        Pose({in(40.0, 160.0, 0.7), in(40.0, 160.0, 1.3), in(40.0, 160.0, 2.9)});
    const Vector3d move_mm(in(-1.0, 1.0, 3.1), in(-1.0, 1.0, 4.7), in(-1.0, 1.0, 5.3));
    const Vector3d turn_rad = 0.02 * Vector3d(in(-1, 1, 1.7), in(-1, 1, 2.3), in(-1, 1, 3.7));
    const Vector3d force(in(-3.0, 3.0, 0.3), in(-3.0, 3.0, 0.9), in(-3.0, 3.0, 2.1));
    ToolTrack track;
    const ToolAtRest tool = AtRest(map, pose, Vector3d::UnitZ(), track);
    Vector3d torque(in(-90.0, 90.0, 0.4), in(-90.0, 90.0, 1.1), in(-90.0, 90.0, 2.7));
    torque -= torque.dot(tool.axis_at_rest) * tool.axis_at_rest;  // A needle's about itself is 0.
    const Works works = WorksOf(map, pose, Vector3d::UnitZ(), force, torque, move_mm, turn_rad);
    worst = std::max(worst, std::abs(works.world - works.rest));
    most_rotated = std::max(most_rotated,
                            std::abs((tool.world_from_rest * force).dot(move_mm) +
                                     (tool.world_from_rest * torque).dot(turn_rad) - works.rest));
  }
  std::printf("  work differs by %.4f N mm at most; by a rotation %.4f\n", worst, most_rotated);
  EXPECT_LT(worst, 0.05);  // Of up to 8 N mm; the rest is the field, linear between nodes.
  EXPECT_GT(most_rotated, 1.0);
}

TEST(BreathingPatient, MovesAsItSaysHoweverFar) {
  testing_support::BreathingPatient patient{.kind = MotionKind::kHalfCycle, .nodes_per_axis = 41};
  patient.box.size.setConstant(201);
  const Eigen::Vector3d middle_mm = Eigen::Vector3d::Constant(100.0);
  for (const double largest_mm : {20.0, 40.0, 200.0}) {
    patient.largest_mm = largest_mm;
    const MotionModel model = patient.Model();
    const Breath breath{.level = 0.0};
    const MotionMap map(model.field(), model.WeightsAt(breath));
    const Eigen::Vector3d wanted_mm = patient.DisplacementMm(breath, middle_mm);
    EXPECT_LT((map.DisplacementMm(middle_mm) - wanted_mm).norm(), 0.02) << largest_mm;
  }
}

TEST(CarriedForces, StayBoundedWhereTheFieldIsNearlySingularOrFolds) {
  testing_support::BreathingPatient patient{.kind = MotionKind::kHalfCycle, .nodes_per_axis = 48};
  patient.box.size.setConstant(201);
  for (const double largest_mm : {55.0, 60.0, 63.0, 64.0, 80.0, 200.0}) {
    patient.largest_mm = largest_mm;
    const MotionModel model = patient.Model();
    const MotionMap map(model.field(), model.WeightsAt({.level = 0.0}));
    for (int n = 0; n < 400; ++n) {
      ToolTrack track;
      const ToolAtRest tool =
          AtRest(map, Pose({100.0, 95.0, 0.5 * n}), Eigen::Vector3d::UnitZ(), track);
      Eigen::Vector3d force(1.0, -2.0, 2.0);
      Eigen::Vector3d torque = Eigen::Vector3d::Zero();
      CarryToWorld(map, tool, force, torque);
      ASSERT_LE(force.norm(), 3.0 * ToolAtRest::kMostPerWorld) << largest_mm << ' ' << n;
      torque = {10.0, 20.0, -20.0};
      CarryToWorld(map, tool, force, torque);
      ASSERT_TRUE(force.allFinite() && torque.allFinite());
    }
  }
}

}  // namespace
}  // namespace acus::breathing
