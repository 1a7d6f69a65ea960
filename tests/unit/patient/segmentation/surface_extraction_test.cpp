#include "acus/patient/segmentation/surfaces/surface_extraction.h"

#include <gmock/gmock.h>
#include <map>

namespace acus::segmentation {
namespace {

/// How often each directed edge occurs; a closed, consistently oriented surface has each once, and
/// its reverse once.
void ExpectClosed(const mesh::Surface& surface) {
  std::map<std::pair<int, int>, int> edges;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    for (int c = 0; c < 3; ++c)
      ++edges[{surface.triangles(c, t), surface.triangles((c + 1) % 3, t)}];
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first}));
  }
}

Mask BallMask(const Eigen::Matrix3d& direction, double cut_at_k_mm) {
  volume::Geometry g;
  g.size = {64, 64, 40};
  g.spacing_mm = {1.0, 1.0, 2.0};
  g.direction = direction;
  g.origin_mm = {10, -20, 30};
  Mask mask(g);
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 64; ++j) {
      for (int i = 0; i < 64; ++i) {
        mask.At(i, j, k) =
            Eigen::Vector3d(i - 32, j - 32, 2 * k - cut_at_k_mm).norm() <= 25.0 ? 1 : 0;
      }
    }
  }
  return mask;
}

constexpr double kBallMl = 4.0 / 3.0 * M_PI * 25 * 25 * 25;

TEST(ExtractSurface, OfABallIsClosedOutwardsAndKeepsItsVolume) {
  const Eigen::Matrix3d oblique =
      Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 1, 2).normalized()).toRotationMatrix();
  Eigen::Matrix3d left = oblique;
  left.col(0) *= -1.0;
  for (const Eigen::Matrix3d& direction : {oblique, left}) {
    const Mask mask = BallMask(direction, 40.0);
    const auto surface = ExtractSurface(mask, {.target_triangles = 3000}, 2);
    ExpectClosed(surface);
    EXPECT_NEAR(mesh::SignedVolumeMm3(surface), kBallMl, 0.01 * kBallMl);
    EXPECT_LE(surface.triangles.cols(), 3100);
    const Eigen::Vector3d centre = mask.geometry.ct_from_index() * Eigen::Vector3d(32, 32, 20);
    for (Eigen::Index n = 0; n < surface.nodes_mm.cols(); ++n) {
      EXPECT_NEAR((surface.nodes_mm.col(n) - centre).norm(), 25.0, 1.0);
    }
  }
}

TEST(ExtractSurface, IsClosedWhereTheBorderCutsTheMask) {
  const Mask mask = BallMask(Eigen::Matrix3d::Identity(), 0.0);  // Half a ball.
  const auto surface = ExtractSurface(mask, {.target_triangles = 3000}, 2);
  ExpectClosed(surface);
  const double voxels_mm3 = static_cast<double>(Count(mask)) * 2.0;
  EXPECT_NEAR(mesh::SignedVolumeMm3(surface), voxels_mm3, 0.02 * voxels_mm3);
}

TEST(ExtractSurface, LeavesOutSmallPartsAndFillsCavities) {
  Mask mask = BallMask(Eigen::Matrix3d::Identity(), 40.0);
  mask.At(2, 2, 2) = 1;
  for (int k = 18; k < 22; ++k) {
    for (int j = 28; j < 36; ++j) mask.At(30, j, k) = 0;
  }
  const auto surface = ExtractSurface(mask, {.target_triangles = 3000}, 2);
  EXPECT_NEAR(mesh::SignedVolumeMm3(surface), kBallMl, 0.01 * kBallMl);
  EXPECT_GT(surface.nodes_mm.row(0).minCoeff(), 10.0 + 5.0);
}

TEST(ExtractSurface, RefusesAnEmptyMask) {
  volume::Geometry g;
  g.size = {4, 4, 4};
  EXPECT_THROW(ExtractSurface(Mask(g), {}, 1), InputError);
  Mask crumb(g);
  crumb.At(1, 1, 1) = 1;
  EXPECT_THROW(ExtractSurface(crumb, {}, 1), InputError);
}

}  // namespace
}  // namespace acus::segmentation
