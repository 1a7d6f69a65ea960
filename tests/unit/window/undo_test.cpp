#include "acus/window/undo.h"

#include <gtest/gtest.h>

namespace acus::window {
namespace {

constexpr double kDtS = 1.0 / 30.0;

Eigen::Isometry3d At(double x_mm, double turn_rad = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().x() = x_mm;
  pose.linear() = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

/// Moves on by the ways back until there is none; @returns the time, s.
double GoBack(MovementHistory& history, Eigen::Isometry3d& goal) {
  for (int i = 0; i < 1000; ++i) {
    const ToolWay way = history.WayBack(goal, kDtS);
    if (way.IsZero()) return i * kDtS;
    goal.translation() += way.way_mm;
    const double angle = way.turn_rad.norm();
    if (angle > 0.0) {
      goal.linear() = Eigen::AngleAxisd(angle, way.turn_rad / angle) * goal.linear();
    }
  }
  return -1.0;
}

TEST(MovementHistory, TakesMovementsBackOneAfterTheOther) {
  MovementHistory history;
  EXPECT_FALSE(history.TakeBack()) << "nothing was moved";
  for (int i = 0; i < 10; ++i) history.Note(At(i), true, 0.1 * i);
  for (int i = 0; i < 10; ++i) history.Note(At(10.0), false, 1.0 + 0.1 * i);
  for (int i = 0; i < 10; ++i) history.Note(At(10.0 + 3.0 * i, 0.03 * i), true, 2.0 + 0.1 * i);
  Eigen::Isometry3d goal = At(40.0, 0.3);
  ASSERT_TRUE(history.TakeBack());
  // 30 mm at 30 mm/s: a hand, not a jump.
  EXPECT_NEAR(GoBack(history, goal), 1.0, 0.1);
  EXPECT_TRUE(goal.isApprox(At(10.0), 1e-3));
  ASSERT_TRUE(history.TakeBack());
  EXPECT_GT(GoBack(history, goal), 0.0);
  EXPECT_TRUE(goal.isApprox(At(0.0), 1e-3));
  EXPECT_FALSE(history.TakeBack());
}

TEST(MovementHistory, EndsWhereTheUserMovesAgain) {
  MovementHistory history;
  history.Note(At(0.0), true, 0.0);
  ASSERT_TRUE(history.TakeBack());
  EXPECT_FALSE(history.WayBack(At(20.0), kDtS).IsZero());
  history.Note(At(19.0), true, 0.1);
  EXPECT_TRUE(history.WayBack(At(19.0), kDtS).IsZero());
  ASSERT_TRUE(history.TakeBack()) << "the new movement can be taken back";
}

}  // namespace
}  // namespace acus::window
