#include "acus/patient/segmentation/voxels/mask.h"

#include <gmock/gmock.h>

#include "acus/base/core/random.h"
#include "acus/patient/segmentation/voxels/metrics.h"

namespace acus::segmentation {
namespace {

Mask Empty(int nx, int ny, int nz, const Eigen::Array3d& spacing_mm) {
  volume::Geometry g;
  g.size = {nx, ny, nz};
  g.spacing_mm = spacing_mm;
  return Mask(g);
}

Mask Ball(const Eigen::Array3d& spacing_mm, const Eigen::Vector3d& centre_mm, double radius_mm,
          int n = 40) {
  Mask mask = Empty(n, n, n, spacing_mm);
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Eigen::Vector3d at = mask.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
        mask.At(i, j, k) = (at - centre_mm).norm() <= radius_mm ? 1 : 0;
      }
    }
  }
  return mask;
}

TEST(Dilated, TakesExactlyTheVoxelsWithinTheRadiusAlsoOnUnevenGrids) {
  Mask point = Empty(21, 21, 21, {1.0, 0.5, 2.0});
  point.At(10, 10, 10) = 1;
  for (const double radius_mm : {0.4, 1.0, 3.3, 5.0}) {
    const Mask ball = Dilated(point, radius_mm, 2);
    for (int k = 0; k < 21; ++k) {
      for (int j = 0; j < 21; ++j) {
        for (int i = 0; i < 21; ++i) {
          const double away_mm = Eigen::Vector3d(i - 10, 0.5 * (j - 10), 2.0 * (k - 10)).norm();
          EXPECT_EQ(ball.At(i, j, k) == 1, away_mm <= radius_mm + 1e-9)
              << radius_mm << ": " << i << " " << j << " " << k;
        }
      }
    }
  }
}

TEST(Eroded, IsTheComplementOfDilatingTheOutsideAndSparesTheBorder) {
  Mask full = Empty(9, 9, 9, {1, 1, 1});
  std::ranges::fill(full.voxels, 1);
  EXPECT_EQ(Count(Eroded(full, 3.0, 1)), full.voxels.size());
  full.At(4, 4, 4) = 0;
  EXPECT_EQ(Count(Eroded(full, 1.0, 1)), full.voxels.size() - 7);
}

TEST(Opened, RemovesAThinPlateAndKeepsABall) {
  Mask mask = Ball({1, 1, 1}, {20, 20, 20}, 10);
  const std::size_t ball = Count(mask);
  for (int k = 0; k < 40; ++k) {
    for (int i = 0; i < 40; ++i) mask.At(i, 33, k) = mask.At(i, 34, k) = 1;
  }
  const Mask opened = Opened(mask, 3.0, 2);
  EXPECT_EQ(opened.At(3, 33, 3), 0);
  EXPECT_NEAR(static_cast<double>(Count(opened)), static_cast<double>(ball),
              0.05 * static_cast<double>(ball));
}

TEST(DistanceMm, AgreesWithBruteForce) {
  Mask mask = Empty(12, 9, 7, {0.7, 1.1, 3.0});
  RandomStream random(4, "points", 0);
  std::vector<Eigen::Vector3d> points;
  for (int n = 0; n < 5; ++n) {
    const int i = static_cast<int>(random.Uniform() * 12);
    const int j = static_cast<int>(random.Uniform() * 9);
    const int k = static_cast<int>(random.Uniform() * 7);
    mask.At(i, j, k) = 1;
    points.push_back(mask.geometry.ct_from_index() * Eigen::Vector3d(i, j, k));
  }
  const auto distance = DistanceMm(mask, 2);
  for (int k = 0; k < 7; ++k) {
    for (int j = 0; j < 9; ++j) {
      for (int i = 0; i < 12; ++i) {
        const Eigen::Vector3d at = mask.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
        double nearest = 1e9;
        for (const auto& point : points) nearest = std::min(nearest, (at - point).norm());
        EXPECT_NEAR(distance.At(i, j, k), nearest, 1e-4);
      }
    }
  }
  EXPECT_TRUE(std::isinf(DistanceMm(Empty(3, 3, 3, {1, 1, 1}), 1).voxels[0]));
}

TEST(ConnectedComponents, JoinsOverFacesOnly) {
  Mask mask = Empty(8, 8, 8, {1, 1, 1});
  // A U in the plane, whose arms meet only in its last row; and a voxel that touches by an edge.
  for (int j = 0; j < 6; ++j) mask.At(0, j, 2) = mask.At(4, j, 2) = 1;
  for (int i = 0; i < 5; ++i) mask.At(i, 6, 2) = 1;
  mask.At(5, 7, 2) = 1;
  mask.At(7, 7, 7) = mask.At(7, 7, 6) = 1;
  const Components parts = ConnectedComponents(mask);
  ASSERT_EQ(parts.num_voxels.size(), 4U);
  EXPECT_EQ(parts.number.At(0, 0, 2), parts.number.At(4, 0, 2));
  EXPECT_NE(parts.number.At(5, 7, 2), parts.number.At(4, 6, 2));
  EXPECT_EQ(parts.num_voxels[static_cast<std::size_t>(parts.number.At(0, 0, 2))], 17U);
  const Mask kept = Kept(
      parts, [&](std::int32_t n) { return parts.num_voxels[static_cast<std::size_t>(n)] == 2; });
  EXPECT_EQ(Count(kept), 2U);
}

TEST(FillInSlices, FillsARingAlongItsAxisOnly) {
  for (int axis = 0; axis < 3; ++axis) {
    Mask mask = Empty(9, 9, 9, {1, 1, 1});
    const auto at = [&](int u, int v, int w) -> std::uint8_t& {
      return axis == 0 ? mask.At(w, u, v) : axis == 1 ? mask.At(u, w, v) : mask.At(u, v, w);
    };
    for (int u = 2; u <= 6; ++u) {
      for (int v = 2; v <= 6; ++v) at(u, v, 4) = u == 2 || u == 6 || v == 2 || v == 6;
    }
    Mask other = mask;
    FillInSlices(mask, axis, 2);
    EXPECT_EQ(Count(mask), 25U) << axis;
    FillInSlices(other, (axis + 1) % 3, 2);
    EXPECT_EQ(Count(other), 16U) << axis;
  }
}

TEST(Dice, OfShiftedBallsFollowsTheLensFormula) {
  const double r = 12.0;
  const double d = 4.0;
  const Mask a = Ball({0.7, 0.7, 0.7}, {12, 14, 14}, r);
  const Mask b = Ball({0.7, 0.7, 0.7}, {12 + d, 14, 14}, r);
  // Intersection of two equal balls at distance d over one ball.
  const double lens = (4 * r + d) * (2 * r - d) * (2 * r - d) / (16.0 * r * r * r);
  EXPECT_NEAR(Dice(a, b), lens, 0.01);
  EXPECT_DOUBLE_EQ(Dice(a, a), 1.0);
  EXPECT_DOUBLE_EQ(Dice(a, Mask(a.geometry)), 0.0);
  EXPECT_DOUBLE_EQ(Dice(Mask(a.geometry), Mask(a.geometry)), 1.0);
}

TEST(SurfaceDistance95, OfConcentricBallsIsTheDifferenceOfRadii) {
  const Mask a = Ball({0.5, 0.5, 0.5}, {10, 10, 10}, 5.0);
  const Mask b = Ball({0.5, 0.5, 0.5}, {10, 10, 10}, 8.0);
  EXPECT_NEAR(SurfaceDistance95Mm(a, b, 2), 3.0, 0.3);
  EXPECT_DOUBLE_EQ(SurfaceDistance95Mm(a, a, 2), 0.0);
}

TEST(SurfaceDistance95, OfShiftedBallsFollowsFromTheAngle) {
  // The distance from a point at angle t to a ball shifted by d << r is about d |cos t|, and cos t
  // is even on a sphere, so its 95 % quantile is 0.95 d.
  const Mask a = Ball({0.5, 0.5, 0.5}, {9, 10, 10}, 7.0);
  const Mask b = Ball({0.5, 0.5, 0.5}, {11, 10, 10}, 7.0);
  EXPECT_NEAR(SurfaceDistance95Mm(a, b, 1), 1.9, 0.25);
  EXPECT_THROW(SurfaceDistance95Mm(a, Mask(a.geometry), 1), InputError);
}

TEST(Metrics, RefuseMasksOfDifferentSize) {
  const Mask a = Empty(3, 3, 3, {1, 1, 1});
  const Mask b = Empty(3, 3, 4, {1, 1, 1});
  EXPECT_THROW(Dice(a, b), InputError);
  EXPECT_THROW(SurfaceDistance95Mm(a, b, 1), InputError);
}

}  // namespace
}  // namespace acus::segmentation
