#include "acus/base/math/rigid.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::math {
namespace {

TEST(RigidFromMatrix, RefusesScaleMirrorAndNan) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  EXPECT_TRUE(RigidFromMatrix(matrix).matrix().isApprox(matrix));
  matrix(0, 0) = -1.0;
  EXPECT_THROW(RigidFromMatrix(matrix), InputError);
  matrix(0, 0) = 1.1;
  EXPECT_THROW(RigidFromMatrix(matrix), InputError);
  matrix(0, 0) = std::nan("");
  EXPECT_THROW(RigidFromMatrix(matrix), InputError);
}

TEST(Interpolate, TurnsHalfTheAngleAtHalfTheDistance) {
  const Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d b(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 2, 3).normalized()));
  b.translation() << 10, 20, 30;
  const Eigen::Isometry3d middle = Interpolate(a, b, 0.5);
  EXPECT_NEAR(AngleBetweenRad(a, middle), 0.5, 1e-12);
  EXPECT_NEAR(AngleBetweenRad(middle, b), 0.5, 1e-12);
  EXPECT_TRUE(middle.translation().isApprox(Eigen::Vector3d(5, 10, 15)));
}

TEST(PoseFromAxes, IsRightHandedAlsoWhenTheHintIsParallel) {
  for (const Eigen::Vector3d& hint : {Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(0, 0, 2)}) {
    const Eigen::Isometry3d pose = PoseFromAxes({1, 2, 3}, {0, 0, 5}, hint);
    EXPECT_TRUE(IsRigid(pose.matrix(), 1e-12));
    EXPECT_TRUE(pose.linear().col(2).isApprox(Eigen::Vector3d::UnitZ()));
  }
  // As near to the hint as can be, however short the axes are.
  const Eigen::Isometry3d pose = PoseFromAxes({}, {0, 0, 1e-6}, {1e-6, 1e-6, 0});
  EXPECT_TRUE(pose.linear().col(0).isApprox(Eigen::Vector3d(1, 1, 0).normalized()));
}

TEST(RasFromLps, IsItsOwnInverse) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 1).normalized()));
  pose.translation() << 1, 2, 3;
  EXPECT_TRUE(RasFromLps(RasFromLps(pose)).isApprox(pose));
  EXPECT_TRUE(RasFromLps(pose).translation().isApprox(Eigen::Vector3d(-1, -2, 3)));
  // A point that is turned goes to the same place in either frame.
  const Eigen::Vector3d lps_mm(4, 5, 6);
  const Eigen::Vector3d turned = pose * lps_mm;
  EXPECT_TRUE((RasFromLps(pose) * Eigen::Vector3d(-4, -5, 6))
                  .isApprox(Eigen::Vector3d(-turned.x(), -turned.y(), turned.z())));
}

TEST(Quantile, InterpolatesBetweenOrderStatistics) {
  const std::vector<double> values{4, 1, 3, 2};
  EXPECT_DOUBLE_EQ(Median(values), 2.5);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(Quantile(values, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.95), 3.85);
  std::vector<double> thousand(1000, 1.0);
  thousand[17] = 9.0;
  EXPECT_EQ(Quantile(thousand, 1.0), 9.0);
  EXPECT_NEAR(Quantile(thousand, 0.9995), 1.0 + 0.5005 * 8.0, 1e-9);
  EXPECT_EQ(Quantile(thousand, 0.998), 1.0);
  EXPECT_EQ(Median(std::vector<double>{INFINITY, 1.0, 2.0}), 2.0);
}

}  // namespace
}  // namespace acus::math
