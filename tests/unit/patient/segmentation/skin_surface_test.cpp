#include "acus/patient/segmentation/surfaces/skin_surface.h"

#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/surfaces/surface_extraction.h"

namespace acus::segmentation {
namespace {

constexpr double kReachMm = 3.0;

/// A box of 60 x 40 mm along the whole of a volume of 80 mm, turned in space, with a layer of
/// skin on four sides; `at_left` is the layer where x is least.
volume::LabelMap Trunk(const char* at_left) {
  volume::Geometry g;
  g.size = {80, 60, 80};
  g.origin_mm = {-30, 20, 100};
  g.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  volume::LabelMap labels(g);
  for (int k = 0; k < 80; ++k) {
    for (int j = 10; j < 50; ++j) {
      for (int i = 10; i < 70; ++i) {
        const bool is_side = i >= 68 || j < 12 || j >= 48;
        const char* name = i < 12 ? at_left : is_side ? "skin" : "soft_tissue";
        labels.At(i, j, k) = volume::LabelOf(name);
      }
    }
  }
  return labels;
}

mesh::Surface SurfaceOfTrunk(const volume::LabelMap& labels) {
  Mask body(labels.geometry);
  for (std::size_t n = 0; n < body.voxels.size(); ++n) body.voxels[n] = labels.voxels[n] != 0;
  return ExtractSurface(body, {.grid_mm = 2.0, .target_triangles = 100000}, 1);
}

/// Area of the triangles that face along `axis` of the grid (negative: against it), mm2.
double AreaFacingMm2(const mesh::Surface& surface, const volume::Geometry& g, int axis, int sign) {
  double area = 0.0;
  for (const auto& t : surface.triangles.colwise()) {
    const Eigen::Vector3d a = surface.nodes_mm.col(t[0]);
    const Eigen::Vector3d n =
        0.5 * (surface.nodes_mm.col(t[1]) - a).cross(surface.nodes_mm.col(t[2]) - a);
    if (sign * n.normalized().dot(g.direction.col(axis)) > 0.9) area += n.norm();
  }
  return area;
}

TEST(SkinSurface, EndsWhereTheVolumeEndsTheBody) {
  const volume::LabelMap labels = Trunk("skin");
  const mesh::Surface body = SurfaceOfTrunk(labels);
  const mesh::Surface skin = SkinOf(body, labels, kReachMm);
  const volume::Geometry& g = labels.geometry;
  EXPECT_GT(AreaFacingMm2(body, g, 2, 1), 0.9 * 60 * 40);
  EXPECT_EQ(AreaFacingMm2(skin, g, 2, 1), 0.0);
  EXPECT_EQ(AreaFacingMm2(skin, g, 2, -1), 0.0);
  for (const int sign : {-1, 1}) {
    // Edges are rounded; no more than the reach is missing at either end.
    EXPECT_NEAR(AreaFacingMm2(skin, g, 0, sign), 40 * 80, 0.15 * 40 * 80);
    EXPECT_NEAR(AreaFacingMm2(skin, g, 0, sign), AreaFacingMm2(body, g, 0, sign),
                2.0 * kReachMm * 40);
    EXPECT_NEAR(AreaFacingMm2(skin, g, 1, sign), AreaFacingMm2(body, g, 1, sign),
                2.0 * kReachMm * 60);
  }
}

TEST(SkinSurface, LeavesOutWhereTheScannersCircleCutsTheBody) {
  const volume::LabelMap labels = Trunk("cut");
  const mesh::Surface body = SurfaceOfTrunk(labels);
  const mesh::Surface skin = SkinOf(body, labels, kReachMm);
  const volume::Geometry& g = labels.geometry;
  EXPECT_GT(AreaFacingMm2(body, g, 0, -1), 0.85 * 40 * 80);
  EXPECT_EQ(AreaFacingMm2(skin, g, 0, -1), 0.0);
  EXPECT_GT(AreaFacingMm2(skin, g, 0, 1), 0.8 * 40 * 80);
  // Every node that is left belongs to a triangle.
  Eigen::VectorXi uses = Eigen::VectorXi::Zero(skin.nodes_mm.cols());
  for (const auto& t : skin.triangles.colwise()) {
    for (const int n : t) ++uses[n];
  }
  EXPECT_GT(uses.minCoeff(), 0);
}

TEST(SkinSurface, ABodyThatIsCutAllAroundHasNone) {
  volume::LabelMap labels = Trunk("cut");
  for (volume::Label& label : labels.voxels) {
    if (label == volume::LabelOf("skin")) label = volume::LabelOf("cut");
  }
  EXPECT_EQ(SkinOf(SurfaceOfTrunk(labels), labels, kReachMm).triangles.cols(), 0);
}

}  // namespace
}  // namespace acus::segmentation
