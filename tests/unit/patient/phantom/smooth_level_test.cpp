#include "acus/patient/phantom/anatomy/smooth_level.h"

#include <gmock/gmock.h>

#include "acus/base/core/random.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

volume::Grid<std::uint8_t> Ball(double radius_mm) {
  volume::Geometry g;
  g.size = {40, 40, 40};
  g.spacing_mm = Eigen::Array3d::Constant(3.0);
  g.origin_mm = Vector3d::Constant(-58.5);
  volume::Grid<std::uint8_t> inside(g);
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        inside.At(i, j, k) = (g.origin_mm + 3.0 * Vector3d(i, j, k)).norm() < radius_mm ? 1 : 0;
      }
    }
  }
  return inside;
}

TEST(SmoothLevel, IsTheDistanceToABall) {
  const SmoothLevel level(Ball(36.0), 4.0, 0.0, 1);
  RandomStream random(1, "ball");
  for (int n = 0; n < 200; ++n) {
    const Vector3d direction =
        Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    // Smoothing raises the distance by sigma^2 / radius (spline and Gaussian: 19 mm^2); the stairs
    // are up to half a voxel high.
    EXPECT_NEAR(level.LevelMm(36.0 * direction), 19.0 / 36.0, 1.5);
    EXPECT_NEAR(level.LevelMm(28.0 * direction), -8.0 + 19.0 / 28.0, 1.5);
    const auto sample = level.At(36.0 * direction);
    EXPECT_GT(sample.gradient.normalized().dot(direction), 0.98);
  }
}

TEST(SmoothLevel, ItsGradientIsItsSlope) {
  const SmoothLevel level(Ball(36.0), 4.0, 0.0, 1);
  RandomStream random(2, "slope");
  for (int n = 0; n < 100; ++n) {
    const Vector3d p(random.Uniform(-55, 55), random.Uniform(-55, 55), random.Uniform(-55, 55));
    const Vector3d gradient = level.At(p).gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d h = 1e-4 * Vector3d::Unit(axis);
      EXPECT_NEAR((level.LevelMm(p + h) - level.LevelMm(p - h)) / 2e-4, gradient[axis], 1e-5);
    }
  }
}

TEST(SmoothLevel, AnOffsetMakesTheBodySmaller) {
  const SmoothLevel level(Ball(36.0), 4.0, 2.0, 1);
  EXPECT_NEAR(level.LevelMm({34.0, 0.0, 0.0}), 0.0, 1.2);
}

TEST(SmoothLevel, DoesNotDependOnThreads) {
  const SmoothLevel one(Ball(30.0), 4.0, 0.0, 1), two(Ball(30.0), 4.0, 0.0, 2);
  RandomStream random(3, "threads");
  for (int n = 0; n < 100; ++n) {
    const Vector3d p(random.Uniform(-80, 80), random.Uniform(-80, 80), random.Uniform(-80, 80));
    EXPECT_EQ(one.LevelMm(p), two.LevelMm(p));
  }
}

TEST(SmoothLevel, RefusesWhatHasNoSurface) {
  EXPECT_THROW(SmoothLevel(Ball(1.0), 4.0, 0.0, 1), InputError);
  EXPECT_THROW(SmoothLevel(Ball(500.0), 4.0, 0.0, 1), InputError);
  auto turned = Ball(30.0);
  turned.geometry.direction.col(0) *= -1.0;
  EXPECT_THROW(SmoothLevel(turned, 4.0, 0.0, 1), InputError);
}

}  // namespace
}  // namespace acus::phantom
