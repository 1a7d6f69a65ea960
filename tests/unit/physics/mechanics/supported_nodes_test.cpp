#include "acus/physics/mechanics/elements/supported_nodes.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::BoxMesh;
using testing_support::Fix;

mesh::TetraMesh HeldBox() {
  mesh::TetraMesh box = BoxMesh({5, 5, 5}, {0, 0, 0}, {50, 50, 50});
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return box;
}

/// Adds a tetrahedron of 0.1 x 0.1 x 0.1 / 6 * size^3 mm^3 on nodes of the mesh and new ones.
void AddTetrahedron(mesh::TetraMesh& mesh, const std::vector<int>& shared,
                    const Eigen::Vector3d& at_mm, double size_mm) {
  const Eigen::Matrix<double, 3, 4> corners{
      {0, size_mm, 0, 0}, {0, 0, size_mm, 0}, {0, 0, 0, size_mm}};
  const auto first = mesh.nodes_mm.cols();
  const int num_new = 4 - static_cast<int>(shared.size());
  mesh.nodes_mm.conservativeResize(3, first + num_new);
  Eigen::Vector4i t;
  for (int c = 0; c < 4; ++c) {
    const int k = c - static_cast<int>(shared.size());
    t[c] = k < 0 ? shared[c] : static_cast<int>(first) + k;
    if (k >= 0) mesh.nodes_mm.col(first + k) = at_mm + corners.col(c);
  }
  mesh.tetrahedra.conservativeResize(4, mesh.tetrahedra.cols() + 1);
  mesh.tetrahedra.rightCols<1>() = t;
  mesh.tissue.push_back(4);
  mesh.fixed_nodes.resize(static_cast<std::size_t>(mesh.nodes_mm.cols()), 0);
}

TEST(FindFreeNodes, AreAllThatAreNotFixed) {
  const mesh::TetraMesh box = HeldBox();
  const FreeNodes free = FindFreeNodes(box);
  EXPECT_EQ(free.mesh_node.size(), 36u * 5u);
  EXPECT_EQ(free.num_dofs(), 3 * 36 * 5);
  EXPECT_TRUE(std::ranges::is_sorted(free.mesh_node));
  EXPECT_EQ(free.row_of_node[0], -1);
  for (std::size_t r = 0; r < free.mesh_node.size(); ++r) {
    EXPECT_EQ(free.row_of_node[free.mesh_node[r]], static_cast<int>(r));
  }
  EXPECT_TRUE(free.loose.empty());
}

TEST(FindFreeNodes, ASmallIslandStaysInPlaceAndIsReported) {
  mesh::TetraMesh box = HeldBox();
  AddTetrahedron(box, {}, {100, 100, 100}, 12.0);
  const FreeNodes free = FindFreeNodes(box);
  ASSERT_EQ(free.loose.size(), 1u);
  EXPECT_EQ(free.loose[0].num_tetrahedra, 1);
  EXPECT_NEAR(free.loose[0].volume_mm3, 12.0 * 12 * 12 / 6, 1e-9);
  EXPECT_NEAR((free.loose[0].centre_mm - Eigen::Vector3d(103, 103, 103)).norm(), 0.0, 1e-9);
  EXPECT_EQ(free.mesh_node.size(), 36u * 5u);
  EXPECT_TRUE(free.is_left_out.back());
  EXPECT_EQ(std::ranges::count(free.is_left_out, 1), 1);
}

TEST(FindFreeNodes, ALargeIslandIsRefusedWithPlaceAndSize) {
  mesh::TetraMesh box = HeldBox();
  AddTetrahedron(box, {}, {100, 200, 300}, 40.0);
  EXPECT_THAT([&] { FindFreeNodes(box); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("1 piece"), HasSubstr("(110, 210, 310) mm"),
                                              HasSubstr("fixed_tissues"))));
}

TEST(FindFreeNodes, WhatHangsByAnEdgeOnlyWouldTurnAndIsOmitted) {
  mesh::TetraMesh box = HeldBox();
  const int corner = static_cast<int>(box.nodes_mm.cols()) - 1;  // At (50, 50, 50).
  AddTetrahedron(box, {corner, corner - 1}, {45, 60, 55}, 1.0);
  const FreeNodes free = FindFreeNodes(box);
  EXPECT_EQ(free.loose.size(), 1u);
  EXPECT_GE(free.row_of_node[corner], 0);  // The box itself moves.
  EXPECT_EQ(free.row_of_node[corner + 1], -1);
}

TEST(FindFreeNodes, APieceOnThreeNodesOfOthersIsHeld) {
  mesh::TetraMesh box = HeldBox();
  const int corner = static_cast<int>(box.nodes_mm.cols()) - 1;
  AddTetrahedron(box, {corner, corner - 1, corner - 6}, {50, 50, 60}, 1.0);
  EXPECT_TRUE(FindFreeNodes(box).loose.empty());
  // Three nodes on one line hold nothing.
  mesh::TetraMesh lined = HeldBox();
  AddTetrahedron(lined, {corner, corner - 1, corner - 2}, {50, 60, 60}, 1.0);
  EXPECT_EQ(FindFreeNodes(lined).loose.size(), 1u);
}

TEST(FindFreeNodes, RefusesMeshesThatCannotBeSolved) {
  mesh::TetraMesh loose = BoxMesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1});
  EXPECT_THAT([&] { FindFreeNodes(loose); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("no node"), HasSubstr("fixed_tissues"))));
  mesh::TetraMesh hinged = loose;
  hinged.fixed_nodes[0] = hinged.fixed_nodes[1] = 1;
  EXPECT_THAT([&] { FindFreeNodes(hinged); }, ThrowsMessage<InputError>(HasSubstr("100 %")));
  mesh::TetraMesh stiff = loose;
  stiff.fixed_nodes.assign(8, 1);
  EXPECT_THAT([&] { FindFreeNodes(stiff); }, ThrowsMessage<InputError>(HasSubstr("every node")));
  mesh::TetraMesh untold = HeldBox();
  untold.tissue.clear();
  EXPECT_THAT([&] { FindFreeNodes(untold); }, ThrowsMessage<InputError>(HasSubstr("tissue ids")));
  mesh::TetraMesh wild = HeldBox();
  wild.tetrahedra(0, 0) = 216;
  EXPECT_THAT([&] { FindFreeNodes(wild); }, ThrowsMessage<InputError>(HasSubstr("not there")));
  EXPECT_THAT([] { FindFreeNodes({}); }, ThrowsMessage<InputError>(HasSubstr("no tetrahedra")));
}

TEST(FindFreeNodes, NodesOfNothingStayInPlace) {
  mesh::TetraMesh box = HeldBox();
  box.nodes_mm.conservativeResize(3, box.nodes_mm.cols() + 1);
  box.nodes_mm.rightCols<1>().setConstant(7.0);
  box.fixed_nodes.push_back(0);
  EXPECT_EQ(FindFreeNodes(box).row_of_node.back(), -1);
}

}  // namespace
}  // namespace acus::mechanics
