#include "acus/data/mesh/triangle_distance.h"

#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::mesh {
namespace {

const Eigen::Vector3d kA(0, 0, 0), kB(4, 0, 0), kC(0, 3, 0);

double Distance(const Eigen::Vector3d& x) {
  return std::sqrt(SquaredDistanceToTriangle(x, kA, kB, kC));
}

TEST(DistanceToTriangle, IsKnownAboveFaceEdgesAndCorners) {
  EXPECT_DOUBLE_EQ(Distance({1, 1, 2}), 2.0);
  EXPECT_DOUBLE_EQ(Distance({-3, -4, 0}), 5.0);
  EXPECT_DOUBLE_EQ(Distance({7, 0, 4}), 5.0);
  EXPECT_DOUBLE_EQ(Distance({0, 6, 4}), 5.0);
  EXPECT_DOUBLE_EQ(Distance({2, -1, 0}), 1.0);
  EXPECT_DOUBLE_EQ(Distance({-2, 1.5, 0}), 2.0);
  // The long edge lies on 3 x + 4 y = 12.
  EXPECT_NEAR(Distance({2 + 0.6 * 5, 1.5 + 0.8 * 5, 0}), 5.0, 1e-12);
}

TEST(TriangleDistance, AgreesWithTryingAllTriangles) {
  RandomStream random(5, "triangles");
  const auto point = [&](double reach) {
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (double& value : out) value = reach * (random.Uniform() - 0.5);
    return out;
  };
  Eigen::Matrix3Xd corners(3, 3 * 400);
  for (int t = 0; t < 400; ++t) {
    const Eigen::Vector3d middle = point(40.0);
    for (int c = 0; c < 3; ++c) corners.col(3 * t + c) << middle + point(5.0);
  }
  const TriangleDistance triangles(corners);
  for (int n = 0; n < 300; ++n) {
    const Eigen::Vector3d x = point(80.0);
    double best = 1e300;
    for (int t = 0; t < 400; ++t) {
      best = std::min(best, SquaredDistanceToTriangle(x, corners.col(3 * t), corners.col(3 * t + 1),
                                                      corners.col(3 * t + 2)));
    }
    EXPECT_DOUBLE_EQ(triangles.At(x, 1000.0), std::sqrt(best));
    EXPECT_DOUBLE_EQ(triangles.At(x, 0.1), std::min(0.1, std::sqrt(best)));
  }
}

TEST(TriangleDistance, OfNothingIsTheLimit) {
  EXPECT_EQ(TriangleDistance(Eigen::Matrix3Xd(3, 0)).At({1, 2, 3}, 7.0), 7.0);
}

}  // namespace
}  // namespace acus::mesh
