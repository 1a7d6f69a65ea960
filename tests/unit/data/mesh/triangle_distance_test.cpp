#include "acus/data/mesh/triangle_distance.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"
#include "acus/data/mesh/nearest_triangle.h"

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

/// Triangles without area are in many files of surfaces.
TEST(DistanceToTriangle, OfATriangleWithoutAreaIsThatOfItsLine) {
  const Eigen::Vector3d a(1, 2, 3), b(5, 0, 4);
  const Eigen::Vector3d middle = a + 0.25 * (b - a);
  const auto of_line = [&](const Eigen::Vector3d& x) {
    const double share = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (x - a - share * (b - a)).squaredNorm();
  };
  RandomStream random(6, "line");
  for (int n = 0; n < 100; ++n) {
    const Eigen::Vector3d x(random.Uniform(-4, 10), random.Uniform(-5, 7), random.Uniform(-2, 9));
    const double expected = of_line(x);
    for (const auto& c : {a, b, middle}) {
      for (const auto& corners : {std::array{a, b, c}, {b, a, c}, {c, a, b}}) {
        EXPECT_NEAR(SquaredDistanceToTriangle(x, corners[0], corners[1], corners[2]), expected,
                    1e-9);
        const Eigen::Vector3d w = NearestWeights(x, corners[0], corners[1], corners[2]);
        const Eigen::Vector3d nearest = w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2];
        EXPECT_NEAR((x - nearest).squaredNorm(), expected, 1e-9);
      }
    }
  }
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
