#include "acus/patient/meshing/material_field.h"

#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/meshing/surface_groups.h"

namespace acus::meshing {
namespace {

/// Tissue in all voxels, to the very sides of the volume.
volume::LabelMap FullBox(const Eigen::Array3i& size) {
  volume::Geometry g;
  g.size = size;
  g.spacing_mm = {1.0, 1.5, 2.0};
  return volume::LabelMap(g, 1);
}

MaterialOfLabel OneMaterial() {
  MaterialOfLabel out{};
  out[1] = 1;
  return out;
}

TEST(MaterialField, ReachesAsFarBeyondTheVolumeAsRequested) {
  for (const double padding_mm : {0.5, 3.0, 7.9}) {
    const volume::LabelMap labels = FullBox({9, 10, 11});
    const MaterialField field(labels, OneMaterial(), 2, 2.0, 0.0, padding_mm, 1);
    for (int d = 0; d < 3; ++d) {
      const double length_mm = (labels.geometry.size[d] - 1) * labels.geometry.spacing_mm[d];
      EXPECT_LE(field.low_mm()[d], -padding_mm) << d;
      EXPECT_GE(field.high_mm()[d], length_mm + padding_mm) << d;
    }
  }
}

TEST(MaterialField, ABoxIsSmoothedAlikeFromAllSides) {
  // Lines of any length.
  for (const int n : {8, 9, 10, 11}) {
    volume::Geometry g;
    g.size = {n, n, n};
    const volume::LabelMap labels(g, 1);
    const MaterialField field(labels, OneMaterial(), 2, 1.0, 1.5, 3.0, 1);
    const double middle = 0.5 * (n - 1);
    for (const double out : {0.0, 2.0, middle, middle + 1.0, middle + 2.0}) {
      const double at = field.Value({middle + out, middle, middle}, 1);
      for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
          Eigen::Vector3d place = Eigen::Vector3d::Constant(middle);
          place[axis] += side * out;
          EXPECT_NEAR(field.Value(place, 1), at, 1e-5) << n << ": " << place.transpose();
        }
      }
    }
    EXPECT_GT(field.Difference({middle, middle, middle}, 1, 0), 0.5);
    EXPECT_LT(field.Difference({middle + 0.5 * n + 2.0, middle, middle}, 1, 0), 0.0);
  }
}

TEST(SurfaceGroups, WhereAllConformTheLargestTissueNeedsNoSurface) {
  volume::Geometry g;
  g.size = {20, 20, 20};
  volume::LabelMap labels(g);  // Most of it is outside.
  for (int n = 0; n < 900; ++n) labels.voxels[static_cast<std::size_t>(n)] = n < 300 ? 4 : 7;
  LabelMeshSettings settings;
  settings.conforming_tissues = {"all"};
  const SurfaceGroups groups = GroupsOf(labels, VolumesMm3(labels), settings);
  EXPECT_EQ(groups.material_of_label[0], 0);
  EXPECT_EQ(groups.material_of_label[7], 1);
  EXPECT_EQ(groups.material_of_label[4], 2);
  EXPECT_EQ(groups.num_materials, 3);
}

}  // namespace
}  // namespace acus::meshing
