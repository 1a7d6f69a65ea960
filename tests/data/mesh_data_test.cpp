// Meshes of real label maps and of surfaces with real defects.
#include <gmock/gmock.h>
#include <map>

#include "core/error.h"
#include "mesh/quality.h"
#include "mesh/surface_io.h"
#include "meshing/label_mesher.h"
#include "meshing/surface_mesher.h"
#include "support/shared_data.h"
#include "volume/volume_io.h"

namespace acus::meshing {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::SharedData;

TEST(RealLabels, OfAnAbdomenBecomeASoundMesh) {
  const auto path = SharedData("ct/ircadb01_labels.vti");
  if (!path) GTEST_SKIP() << "test data ct/ircadb01_labels.vti is not here";
  const auto values = volume::ReadIntegerVolume(*path);
  const std::map<int, int> names = {{0, 0},   {65, 5},   {129, 9},  {193, 9}, {385, 10},
                                    {449, 8}, {451, 12}, {513, 11}, {17, 11}, {33, 11}};
  volume::LabelMap labels(values.geometry);
  labels.names = {{4, "soft_tissue"}, {5, "bone"},    {8, "liver"},  {9, "kidney"},
                  {10, "spleen"},     {11, "vessel"}, {12, "lesion"}};
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    const auto name = names.find(values.voxels[n]);
    labels.voxels[n] = static_cast<std::uint8_t>(name == names.end() ? 4 : name->second);
  }
  const LabelMesh out = MeshLabelMap(labels, {}, {});
  const mesh::QualityReport quality = mesh::MeasureQuality(out.mesh);
  EXPECT_EQ(quality.num_inverted, 0);
  EXPECT_GE(quality.min_dihedral_deg, 8.0);
  EXPECT_NEAR(out.body_mesh_ml, out.body_map_ml, 0.03 * out.body_map_ml);
  for (const TissueVolume& tissue : out.tissues) {
    EXPECT_NEAR(tissue.mesh_ml, tissue.map_ml, 0.03 * tissue.map_ml) << tissue.name;
  }
  EXPECT_LT(quality.num_nodes, 100000);
}

class BrokenSurface : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, BrokenSurface,
                         testing::Values("dragon.stl", "c_open.obj", "self_intersectA.obj"));

TEST_P(BrokenSurface, EndsInAMessageWithThePlace) {
  const auto path = SharedData((std::string("meshes/") + GetParam()).c_str());
  if (!path) GTEST_SKIP() << "test data meshes is not here";
  EXPECT_THAT([&] { MeshSurface(mesh::ReadSurface(*path), GetParam(), {}, {}); },
              ThrowsMessage<InputError>(testing::AllOf(
                  HasSubstr(GetParam()), HasSubstr("first at ("), HasSubstr("try:"))));
}

class SoundSurface : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, SoundSurface, testing::Values("liver.obj", "liver-smooth.obj"));

TEST_P(SoundSurface, IsFilledToItsVolume) {
  const auto path = SharedData((std::string("meshes/") + GetParam()).c_str());
  if (!path) GTEST_SKIP() << "test data meshes is not here";
  const SurfaceMesh out = MeshSurface(mesh::ReadSurface(*path), GetParam(), {}, {});
  EXPECT_GE(mesh::MeasureQuality(out.mesh).min_dihedral_deg, 8.0);
  EXPECT_NEAR(out.mesh_ml, out.surface_ml, 0.01 * out.surface_ml);
}

}  // namespace
}  // namespace acus::meshing
