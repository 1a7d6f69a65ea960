#include "acus/patient/meshing/specks.h"

#include <gtest/gtest.h>

#include "acus/patient/meshing/label_mesher.h"
#include "unit/patient/meshing/label_maps.h"

namespace acus::meshing {
namespace {

using label_maps::kBone;
using label_maps::kFat;
using label_maps::kLiver;

constexpr SpeckLimits kTwoVoxels = {.speck_mm3 = 2.5, .island_share = 0.01};

MaterialOfLabel BoneAndRest() {
  MaterialOfLabel out;
  out.fill(1);
  out[0] = 0;
  out[kBone] = 2;
  return out;
}

/// A block of fat with a margin of 2 voxels of 1 mm around it.
volume::LabelMap Block() {
  return label_maps::Make(16, 1.0, [](const Eigen::Vector3d& x) -> std::uint8_t {
    return x.cwiseAbs().maxCoeff() < 6.0 ? kFat : 0;
  });
}

TEST(WithoutSpecks, GivesSmallPiecesToWhatIsAroundThem) {
  volume::LabelMap labels = Block();
  labels.At(8, 8, 8) = kBone;
  labels.At(8, 8, 9) = kBone;
  labels.At(5, 5, 5) = 0;
  const CleanedMap out = WithoutSpecks(labels, BoneAndRest(), kTwoVoxels);
  EXPECT_EQ(out.labels.voxels, Block().voxels);
  EXPECT_DOUBLE_EQ(out.specks_ml, 0.003);
  EXPECT_DOUBLE_EQ(out.islands_ml, 0.0);
}

TEST(WithoutSpecks, KeepsWhatIsLargeEnough) {
  volume::LabelMap labels = Block();
  for (int k = 7; k < 10; ++k) labels.At(8, 8, k) = kBone;
  for (int k = 7; k < 10; ++k) labels.At(5, 5, k) = 0;
  const CleanedMap out = WithoutSpecks(labels, BoneAndRest(), kTwoVoxels);
  EXPECT_EQ(out.labels.voxels, labels.voxels);
  EXPECT_EQ(out.specks_ml, 0.0);
}

TEST(WithoutSpecks, TissuesOfOneMaterialAreNotDisturbed) {
  volume::LabelMap labels = Block();
  labels.At(8, 8, 8) = kLiver;
  EXPECT_EQ(WithoutSpecks(labels, BoneAndRest(), kTwoVoxels).labels.voxels, labels.voxels);
}

TEST(WithoutSpecks, CountsWhatIsBeyondTheVolumeAsOutside) {
  volume::LabelMap labels =
      label_maps::Make(8, 1.0, [](const Eigen::Vector3d&) -> std::uint8_t { return kFat; });
  labels.At(0, 3, 3) = 0;  // A notch.
  EXPECT_EQ(WithoutSpecks(labels, BoneAndRest(), kTwoVoxels).labels.voxels, labels.voxels);
  labels.At(0, 5, 5) = kBone;  // Touches fat five times, and the outside once.
  EXPECT_EQ(WithoutSpecks(labels, BoneAndRest(), kTwoVoxels).labels.At(0, 5, 5), kFat);
}

TEST(WithoutSpecks, RemovesLooseIslandsOfTheBody) {
  volume::LabelMap labels = Block();
  for (int k = 4; k < 8; ++k) labels.At(0, 0, k) = kFat;
  const CleanedMap out = WithoutSpecks(labels, BoneAndRest(), kTwoVoxels);
  EXPECT_EQ(out.labels.voxels, Block().voxels);
  EXPECT_DOUBLE_EQ(out.islands_ml, 0.004);
}

TEST(MeshLabelMap, SlicesTenTimesAsThickAsPixelsKeepTheBodysVolume) {
  volume::Geometry geometry;
  geometry.size = {60, 60, 8};
  geometry.spacing_mm = {2.0, 2.0, 20.0};
  volume::LabelMap labels(geometry);
  labels.names = {{kFat, "fat"}};
  for (int k = 0; k < 8; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d x(2.0 * i - 59.0, 2.0 * j - 59.0, 20.0 * k - 70.0);
        if ((x.array() / Eigen::Array3d(50.0, 50.0, 75.0)).matrix().norm() < 1.0) {
          labels.At(i, j, k) = kFat;
        }
      }
    }
  }
  const LabelMesh mesh = MeshLabelMap(labels, {}, {});
  EXPECT_NEAR(mesh.body_mesh_ml, mesh.body_map_ml, 0.01 * mesh.body_map_ml);
}

}  // namespace
}  // namespace acus::meshing
