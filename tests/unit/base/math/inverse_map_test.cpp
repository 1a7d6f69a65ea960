#include "acus/base/math/inverse_map.h"

#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>

namespace acus::math {
namespace {

TEST(InvertDisplacement, InvertsALinearFieldToTheTolerance) {
  Eigen::Matrix3d strain;
  strain << 0.3, -0.2, 0.1, 0.1, -0.4, 0.2, 0.0, 0.2, 0.35;
  const auto u = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return strain * x; };
  const Eigen::Vector3d x(10, -20, 30);
  const Eigen::Vector3d truth = (Eigen::Matrix3d::Identity() + strain).inverse() * x;
  const InversePoint found =
      InvertDisplacement(u, x, x, {.max_iterations = 100, .tolerance_mm = 1e-9});
  EXPECT_LT((found.rest_mm - truth).norm(), 1e-8);
  EXPECT_LE(found.residual_mm, 1e-9);
}

TEST(InvertDisplacement, ReturnsThePlaceItselfWhereNothingMoves) {
  const auto u = [](const Eigen::Vector3d&) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); };
  const Eigen::Vector3d x(0.1, 1.0 / 3.0, -7.7);
  const InversePoint found = InvertDisplacement(u, x, x);
  EXPECT_EQ(found.rest_mm, x);
  EXPECT_EQ(found.iterations, 0);
}

/// A strain of 1.6 makes the plain fixed point run away; halved steps find the answer.
TEST(InvertDisplacement, ConvergesBeyondStrainOneWhereTheMapIsStillOneToOne) {
  const auto u = [](const Eigen::Vector3d& x) -> Eigen::Vector3d { return 1.6 * x; };
  const Eigen::Vector3d x(5, 2, -3);
  const InversePoint found = InvertDisplacement(u, x, x, {.max_iterations = 60});
  EXPECT_LT((found.rest_mm - x / 2.6).norm(), 1e-3);
}

TEST(InvertDisplacement, StaysBoundedAndSaysSoWhereTheFieldFoldsOrJumps) {
  const auto jump = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return x[2] > 0 ? Eigen::Vector3d(0, 0, 4) : Eigen::Vector3d::Zero();
  };
  const Eigen::Vector3d in_the_gap(1, 2, 2);  // z from 0 to 4 is reached from nowhere.
  const InversePoint gap = InvertDisplacement(jump, in_the_gap, in_the_gap);
  EXPECT_LE(gap.iterations, 20);
  EXPECT_LE(gap.residual_mm, 4.0);
  EXPECT_LE((gap.rest_mm - in_the_gap).norm(), 8.0);

  const auto fold = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return {0, 0, -3.0 * std::sin(x[2])};
  };
  for (double z = -5; z < 5; z += 0.37) {
    const Eigen::Vector3d x(0, 0, z);
    const InversePoint found = InvertDisplacement(fold, x, x);
    EXPECT_TRUE(found.rest_mm.allFinite());
    EXPECT_LE(found.residual_mm, 3.0);
  }
}

}  // namespace
}  // namespace acus::math
