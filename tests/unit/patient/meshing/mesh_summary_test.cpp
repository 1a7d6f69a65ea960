#include "acus/patient/meshing/mesh_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"

namespace acus::meshing {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Two tetrahedra that share a face: liver and, over it, bone, whose four nodes are held.
mesh::TetraMesh LiverUnderBone() {
  mesh::TetraMesh mesh;
  mesh.nodes_mm.resize(3, 5);
  mesh.nodes_mm << 0, 10, 0, 3, 3,  //
      0, 0, 10, 3, 3,               //
      0, 0, 0, -10, 10;
  mesh.tetrahedra.resize(4, 2);
  mesh.tetrahedra << 0, 0,  //
      2, 1,                 //
      1, 2,                 //
      3, 4;
  mesh.tissue = {volume::LabelOf("liver"), volume::LabelOf("bone")};
  mesh.fixed_nodes = {1, 1, 1, 0, 1};
  return mesh;
}

const std::vector<TissueVolume> kSummarised = {
    {.label = volume::LabelOf("bone"),
     .name = "bone",
     .map_ml = 1.0,
     .mesh_ml = 1.0,
     .is_conforming = true},
    {.label = volume::LabelOf("liver"), .name = "liver", .map_ml = 1.0, .mesh_ml = 1.0},
    {.label = volume::LabelOf("vessel"), .name = "vessel", .map_ml = 0.25, .mesh_ml = 0.0}};

std::string WarningWithout(mesh::TetraMesh mesh, bool held) {
  if (!held) mesh.fixed_nodes.assign(5, 0);
  std::string warning;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warning = text; };
  WarnWithoutFixedNodes(mesh, kSummarised, {"bone"}, context);
  return warning;
}

TEST(MeshText, CountsFixedNodesByTissueAndNamesWhatIsMissing) {
  EXPECT_THAT(
      MeshText(LiverUnderBone(), kSummarised, {"bone"}, {.islands_ml = 0.5}),
      AllOf(HasSubstr("Mesh: 5 nodes, 2 tetrahedra, smallest dihedral angle "),
            HasSubstr("Fixed nodes: 4, in bone 4\n"), HasSubstr("Tissues: bone, liver, vessel\n"),
            HasSubstr("With a surface of faces: body, bone\n"),
            HasSubstr("Not in the mesh: vessel (0.25 ml, too small for the elements), 0.5 ml in "
                      "loose pieces of the body\n")));
}

TEST(MeshText, SaysThatNothingHoldsAMesh) {
  mesh::TetraMesh mesh = LiverUnderBone();
  mesh.fixed_nodes.assign(5, 0);
  EXPECT_THAT(MeshText(mesh, {}, {"bone"}, {}),
              HasSubstr("Fixed nodes: 0: nothing holds the mesh\n"));
}

TEST(WarnWithoutFixedNodes, NamesTheTissuesThatCouldBeHeld) {
  EXPECT_EQ(WarningWithout(LiverUnderBone(), true), "");
  EXPECT_THAT(WarningWithout(LiverUnderBone(), false),
              AllOf(HasSubstr("fixed_nodes: 0"), HasSubstr("\"fixed_tissues\""),
                    HasSubstr("of bone, liver, vessel")));
}

}  // namespace
}  // namespace acus::meshing
