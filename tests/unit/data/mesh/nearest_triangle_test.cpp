#include "acus/data/mesh/nearest_triangle.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/mesh/triangle_distance.h"
#include "support/bumpy_surface.h"

namespace acus::mesh {
namespace {

using Eigen::Vector3d;

TEST(NearestTriangle, FindsWhatLookingAtAllFinds) {
  const Surface surface = testing_support::Trunk(16, 24);
  const NearestTriangle nearest(surface);
  RandomStream random(1, "places");
  for (int i = 0; i < 300; ++i) {
    const Vector3d x_mm(random.Uniform(-200, 200), random.Uniform(-200, 200),
                        random.Uniform(-250, 250));
    double least = 1e300;
    for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
      const Eigen::Vector3i corner = surface.triangles.col(t);
      least = std::min(least, SquaredDistanceToTriangle(x_mm, surface.nodes_mm.col(corner[0]),
                                                        surface.nodes_mm.col(corner[1]),
                                                        surface.nodes_mm.col(corner[2])));
    }
    const NearestPoint found = nearest.Find(x_mm);
    EXPECT_NEAR(found.squared_mm2, least, 1e-9 * (1 + least));
    Vector3d point_mm = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      point_mm += found.weights[k] * surface.nodes_mm.col(surface.triangles(k, found.triangle));
    }
    EXPECT_LT((point_mm - found.point_mm).norm(), 1e-9);
    EXPECT_NEAR((x_mm - found.point_mm).squaredNorm(), found.squared_mm2, 1e-9 * (1 + least));
  }
}

TEST(NearestTriangle, IsTheNearestPointOfOneTriangleInAllItsRegions) {
  Surface surface;
  surface.nodes_mm.resize(3, 3);
  surface.nodes_mm << 0, 4, 1, 0, 1, 3, 0, 0, 1;
  surface.triangles.resize(3, 1);
  surface.triangles << 0, 1, 2;
  const NearestTriangle nearest(surface);
  RandomStream random(2, "around");
  for (int i = 0; i < 500; ++i) {
    const Vector3d x_mm(random.Uniform(-4, 8), random.Uniform(-4, 8), random.Uniform(-3, 3));
    const NearestPoint found = nearest.Find(x_mm);
    EXPECT_NEAR(found.squared_mm2,
                SquaredDistanceToTriangle(x_mm, surface.nodes_mm.col(0), surface.nodes_mm.col(1),
                                          surface.nodes_mm.col(2)),
                1e-9);
    Eigen::Map<const Vector3d> weights(found.weights.data());
    EXPECT_GE(weights.minCoeff(), -1e-12);
    EXPECT_NEAR(weights.sum(), 1.0, 1e-12);
    EXPECT_LT((surface.nodes_mm * weights - found.point_mm).norm(), 1e-9);
    EXPECT_NEAR((x_mm - found.point_mm).squaredNorm(), found.squared_mm2, 1e-9);
  }
}

TEST(NearestTriangle, NormalsPointOutwards) {
  const NearestTriangle nearest(testing_support::Ball(50));
  const NearestPoint found = nearest.Find({60, 20, 10});
  EXPECT_GT(nearest.Normal(found.triangle).dot(found.point_mm.normalized()), 0.99);
}

TEST(NearestTriangle, RefusesABrokenSurface) {
  EXPECT_THROW(NearestTriangle(Surface{}), InputError);
  Surface surface = testing_support::Trunk(4, 6);
  surface.triangles(1, 3) = 1000;
  EXPECT_THROW(NearestTriangle{surface}, InputError);
}

}  // namespace
}  // namespace acus::mesh
