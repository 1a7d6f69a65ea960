#include "acus/patient/meshing/surface_mesher.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/surface_voxels.h"
#include "unit/data/mesh/shapes.h"

namespace acus::meshing {
namespace {

using mesh::shapes::Icosphere;
using mesh::shapes::Joined;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(MeshSurface, FillsACubeExactly) {
  SurfaceMeshSettings settings;
  settings.tissue = 8;
  settings.is_fixed = true;
  const SurfaceMesh out = MeshSurface(mesh::shapes::Cube(10.0), "cube", settings, {});
  EXPECT_FALSE(out.is_remeshed);
  EXPECT_NEAR(out.mesh_ml, 1.0, 1e-12);
  EXPECT_GE(mesh::MeasureQuality(out.mesh).min_dihedral_deg, 8.0);
  EXPECT_THAT(out.mesh.tissue, testing::Each(8));
  EXPECT_THAT(out.mesh.fixed_nodes, testing::Each(1));
}

TEST(MeshSurface, ObeysTheElementSize) {
  SurfaceMeshSettings settings;
  const auto coarse = MeshSurface(Icosphere(20.0, 3), "sphere", settings, {});
  settings.tetgen.element_size_mm = 2.0;
  const auto fine = MeshSurface(Icosphere(20.0, 3), "sphere", settings, {});
  EXPECT_NEAR(coarse.mesh_ml, coarse.surface_ml, 1e-9 * coarse.surface_ml);
  EXPECT_GT(fine.mesh.tetrahedra.cols(), 3 * coarse.mesh.tetrahedra.cols());
}

TEST(MeshSurface, MakesASurfaceOfThinTrianglesAgain) {
  std::vector<std::string> warnings;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warnings.emplace_back(text); };
  SurfaceMeshSettings settings;
  settings.min_dihedral_deg = 12.0;
  mesh::Surface slivers = mesh::shapes::Cube(20.0);
  slivers.nodes_mm(0, 7) += 0.6;  // Bent faces, of triangles that are far from even.
  slivers.nodes_mm(1, 3) -= 19.0;
  const SurfaceMesh out = MeshSurface(slivers, "slivers", settings, context);
  EXPECT_GE(mesh::MeasureQuality(out.mesh).min_dihedral_deg, 12.0);
  EXPECT_NEAR(out.mesh_ml, out.surface_ml, 0.03 * out.surface_ml);
  EXPECT_EQ(out.is_remeshed, !warnings.empty());
}

TEST(MeshSurface, SaysWhatIsWrongAndWhere) {
  const auto cut = Joined(Icosphere(10.0, 2), Icosphere(10.0, 2, {10, 0.1, 0.2}));
  EXPECT_THAT([&] { MeshSurface(cut, "two.stl", {}, {}); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("two.stl: cannot be filled"),
                                              HasSubstr("cut each other, the first at ("),
                                              HasSubstr("try:"))));
}

double MeshedVolumeMl(const mesh::Surface& surface, SurfaceMesh& out) {
  SurfaceMeshSettings settings;
  EXPECT_THROW(MeshSurface(surface, "shells", settings, {}), InputError);
  settings.may_repair = true;
  settings.tetgen.element_size_mm = 1.0;
  out = MeshSurface(surface, "shells", settings, {});
  EXPECT_GE(mesh::MeasureQuality(out.mesh).min_dihedral_deg, settings.min_dihedral_deg);
  return out.mesh_ml;
}

TEST(MeshSurface, FillsTheUnionOfOverlappingShells) {
  SurfaceMesh out;
  const auto two = Joined(mesh::shapes::Cube(10.0), mesh::shapes::Cube(10.0, {5, 5, 5}));
  EXPECT_NEAR(MeshedVolumeMl(two, out), 1.875, 0.03 * 1.875);
  EXPECT_NEAR(out.surface_ml, 1.875, 0.02 * 1.875);
  EXPECT_THAT(out.repairs, testing::Contains(HasSubstr("the union of 2 shell(s) is filled")));
  // A shell that faces inwards and cuts another one is no cavity.
  mesh::Surface inwards = mesh::shapes::Cube(10.0, {5, 5, 5});
  inwards.triangles.row(1).swap(inwards.triangles.row(2));
  EXPECT_NEAR(MeshedVolumeMl(Joined(mesh::shapes::Cube(20.0),
                                    Joined(inwards, mesh::shapes::Cube(10.0, {12, 12, 12}))),
                             out),
              8.0 + 1.0 - 0.512, 0.03 * 8.5);
}

TEST(MeshSurface, KeepsCavitiesAndCountsNestedShellsOnce) {
  SurfaceMeshSettings settings;
  settings.tetgen.element_size_mm = 1.5;
  mesh::Surface cavity = mesh::shapes::Cube(8.0, {6, 6, 6});
  const auto nested = MeshSurface(Joined(mesh::shapes::Cube(20.0), cavity), "nested", settings, {});
  EXPECT_NEAR(nested.mesh_ml, 8.0, 0.03 * 8.0);
  EXPECT_NEAR(nested.surface_ml, 8.0, 0.02 * 8.0);
  cavity.triangles.row(1).swap(cavity.triangles.row(2));
  const auto hollow = MeshSurface(Joined(mesh::shapes::Cube(20.0), cavity), "hollow", settings, {});
  EXPECT_NEAR(hollow.mesh_ml, 8.0 - 0.512, 0.03 * 8.0);
  EXPECT_NEAR(hollow.surface_ml, 8.0 - 0.512, 0.02 * 8.0);
}

TEST(MeshSurface, ClosesCracksByJoiningNodesOnRequest) {
  // The lid of a box lies 0.01 mm above its walls.
  mesh::Surface box = mesh::shapes::Cube(20.0);
  mesh::Surface cracked = box;
  cracked.nodes_mm.conservativeResize(3, 12);
  for (int n = 4; n < 8; ++n) {
    cracked.nodes_mm.col(n + 4) = box.nodes_mm.col(n) + Eigen::Vector3d(0, 0, 0.01);
  }
  for (int t = 2; t < 4; ++t) cracked.triangles.col(t).array() += 4;
  SurfaceMeshSettings settings;
  settings.may_repair = true;
  const SurfaceMesh out = MeshSurface(cracked, "lid", settings, {});
  EXPECT_NEAR(out.mesh_ml, 8.0, 0.01);
  EXPECT_THAT(out.repairs, testing::Contains(HasSubstr("cracks of up to")));
  EXPECT_THAT(out.repairs, testing::Not(testing::Contains(HasSubstr("hole"))));
}

TEST(VoxelsInside, CountTheVolumeOfOverlapsOnce) {
  const double voxel_mm = 0.5;
  const auto volume_of = [&](const mesh::Surface& surface) {
    const volume::LabelMap labels = VoxelsInside(surface, voxel_mm, 3);
    return static_cast<double>(std::ranges::count(labels.voxels, 3)) * std::pow(voxel_mm, 3);
  };
  const double one = SignedVolumeMm3(Icosphere(10.0, 4));
  EXPECT_NEAR(volume_of(Icosphere(10.0, 4)), one, 0.005 * one);
  EXPECT_NEAR(volume_of(mesh::shapes::Cube(10.0)), 1000.0, 30.0);
  EXPECT_NEAR(volume_of(Joined(Icosphere(10.0, 4), Icosphere(5.0, 3))), one, 0.005 * one);
  EXPECT_THROW(VoxelsInside(Icosphere(10.0, 1), 0.001, 1), InputError);
}

}  // namespace
}  // namespace acus::meshing
