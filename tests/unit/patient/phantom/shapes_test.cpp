#include "acus/patient/phantom/anatomy/shapes.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

/// Volume by counting points of a fine lattice: independent of how the distance is computed.
double VolumeMm3(const Shape& shape, double step_mm) {
  double volume = 0.0;
  const Box& box = shape.bounds_mm;
  for (double z = box.min().z() + step_mm / 2; z < box.max().z(); z += step_mm) {
    for (double y = box.min().y() + step_mm / 2; y < box.max().y(); y += step_mm) {
      for (double x = box.min().x() + step_mm / 2; x < box.max().x(); x += step_mm) {
        if (shape.distance_mm(Vector3d(x, y, z)) < 0.0) volume += step_mm * step_mm * step_mm;
      }
    }
  }
  return volume;
}

TEST(Ellipsoid, HasItsVolumeAndFitsItsBox) {
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Shape shape = Ellipsoid({3, -2, 5}, {12, 7, 9}, turned);
  const double truth = 4.0 / 3.0 * std::numbers::pi * 12 * 7 * 9;
  EXPECT_NEAR(VolumeMm3(shape, 0.4), truth, 0.005 * truth);
  // The box touches the surface: no more than it, no less.
  EXPECT_NEAR(
      VolumeMm3({shape.distance_mm, Box(Vector3d(-20, -20, -20), Vector3d(20, 20, 20))}, 0.5),
      truth, 0.01 * truth);
}

TEST(Ellipsoid, IsAnExactDistanceForASphere) {
  for (const double r : {1.0, 5.0, 9.0, 14.0}) {
    const double distance =
        EllipsoidDistance(r * Vector3d(1, 2, -2) / 3.0, Vector3d::Constant(9.0));
    EXPECT_NEAR(distance, r - 9.0, 1e-12);
  }
}

TEST(Tube, HasTheVolumeOfACylinderWithRoundEnds) {
  const Shape shape = Tube({{0, 0, 0}, {0, 0, 30}}, {5, 5});
  const double truth = std::numbers::pi * (25 * 30 + 4.0 / 3.0 * 125);
  EXPECT_NEAR(VolumeMm3(shape, 0.4), truth, 0.005 * truth);
}

TEST(RoundedBox, HasTheVolumeOfABoxLessItsEdges) {
  const Shape shape{[](const Vector3d& p) {
                      return RoundedBoxDistance(p, {10, 8, 6}, 2.0);
                    },
                    Box(Vector3d(-10, -8, -6), Vector3d(10, 8, 6))};
  // Steiner's formula for the inner box (8, 6, 4) grown by 2.
  const double inner = 8 * 16 * 12 / 1.0, area = 2 * (16 * 12 + 12 * 8 + 8 * 16),
               edges = 4 * (16 + 12 + 8);
  const double truth =
      inner + 2 * area + std::numbers::pi * 4 / 4 * edges + 4.0 / 3.0 * std::numbers::pi * 8;
  EXPECT_NEAR(VolumeMm3(shape, 0.25), truth, 0.005 * truth);
}

TEST(Superellipse, DistanceVanishesOnTheCurveAndGrowsAtUnitRate) {
  for (double azimuth = 0.05; azimuth < 6.28; azimuth += 0.3) {
    const Eigen::Vector2d point = SuperellipsePoint(azimuth, 150, 110);
    EXPECT_NEAR(SuperellipseDistance(point.x(), point.y(), 150, 110), 0.0, 1e-9);
    constexpr double kStep = 1e-3;
    const auto at = [&](double dx, double dy) {
      return SuperellipseDistance(point.x() + dx, point.y() + dy, 150, 110);
    };
    const Eigen::Vector2d gradient((at(kStep, 0) - at(-kStep, 0)) / (2 * kStep),
                                   (at(0, kStep) - at(0, -kStep)) / (2 * kStep));
    EXPECT_NEAR(gradient.norm(), 1.0, 1e-4) << "at azimuth " << azimuth;
  }
}

TEST(SmoothUnion, IsSymmetricBelowBothAndExactFarFromTheSeam) {
  RandomStream random(5, "seam");
  for (int i = 0; i < 1000; ++i) {
    const double a = random.Uniform(-10, 10), b = random.Uniform(-10, 10);
    const double both = SmoothUnion(a, b, 3.0);
    EXPECT_EQ(both, SmoothUnion(b, a, 3.0));
    EXPECT_LE(both, std::min(a, b));
    EXPECT_GE(both, std::min(a, b) - 0.75);
    if (std::abs(a - b) > 3.0) {
      EXPECT_EQ(both, std::min(a, b));
    }
    EXPECT_GE(SmoothIntersection(a, b, 3.0), std::max(a, b));
  }
}

TEST(Moved, CarriesTheShapeAndItsBox) {
  const Eigen::Isometry3d pose =
      Eigen::Translation3d(10, 20, -5) * Eigen::AngleAxisd(1.1, Vector3d(1, 1, 0).normalized());
  const Shape shape = Ellipsoid({1, 2, 3}, {4, 3, 2});
  const Shape moved = Moved(Grown(shape, 0.5), pose);
  RandomStream random(6, "points");
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p(random.Uniform(-8, 8), random.Uniform(-8, 8), random.Uniform(-8, 8));
    EXPECT_NEAR(moved.distance_mm(pose * p), shape.distance_mm(p) - 0.5, 1e-9);
    EXPECT_TRUE(moved.distance_mm(pose * p) >= 0.0 || moved.bounds_mm.contains(pose * p));
  }
}

TEST(Profile, GoesThroughItsKnotsAndNeverOvershoots) {
  const Profile profile{{0, 1}, {1, 5}, {3, 5.5}, {4, 2}};
  EXPECT_EQ(profile(-1), 1.0);
  EXPECT_EQ(profile(9), 2.0);
  for (const auto& [x, y] : {std::pair{0.0, 1.0}, {1.0, 5.0}, {3.0, 5.5}, {4.0, 2.0}}) {
    EXPECT_NEAR(profile(x), y, 1e-12);
  }
  for (int i = 0; i < 400; ++i) {
    const double step = profile(0.01 * (i + 1)) - profile(0.01 * i);
    EXPECT_GE(i < 300 ? step : -step, -1e-12) << "at " << 0.01 * i;
  }
}

}  // namespace
}  // namespace acus::phantom
