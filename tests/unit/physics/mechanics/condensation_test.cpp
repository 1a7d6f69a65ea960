#include "acus/physics/mechanics/condensation/condensation.h"

#include <gmock/gmock.h>

#include "acus/physics/mechanics/sparse/sparse_factor.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

ElasticityTable Table() {
  ElasticityTable table;
  table.tissue[4] = {0.005, 0.45};
  table.tissue[3] = {5.0, 0.3};  // A thousand times stiffer.
  table.named.set(4).set(3);
  return table;
}

mesh::TetraMesh Box(const Eigen::Vector3i& cells) {
  mesh::TetraMesh mesh =
      testing_support::BoxMesh(cells, {0, 0, 0}, 4.0 * cells.cast<double>(), 0.15);
  testing_support::Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return mesh;
}

/// The compliance by one solve for each column.
Eigen::MatrixXd BySolves(const mesh::TetraMesh& mesh, const FreeNodes& free,
                         const std::vector<int>& forces_on, const std::vector<int>& seen_at) {
  const SparseFactor factor(FreeStiffness(
      AssembleStiffness(mesh, Table(), ElementKind::kLinear, free.is_left_out), free));
  const auto dofs = [&](const std::vector<int>& nodes) {
    std::vector<int> out;
    for (const int node : nodes) {
      for (int axis = 0; axis < 3; ++axis) out.push_back(3 * free.row_of_node[node] + axis);
    }
    return out;
  };
  const std::vector<int> columns = dofs(forces_on);
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(free.num_dofs(), columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) unit(columns[j], j) = 1.0;
  return factor.Solve(unit)(dofs(seen_at), Eigen::all);
}

Condensation Condensed(const mesh::TetraMesh& mesh, const FreeNodes& free,
                       const std::vector<int>& reachable) {
  return {mesh, free, Table(), ElementKind::kLinear, reachable, kDefaultMemoryMib, RunContext{}};
}

double RelativeDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

/// Free nodes with a remainder: scattered over the whole mesh.
std::vector<int> EveryNth(const FreeNodes& free, int n) {
  std::vector<int> nodes;
  for (std::size_t i = 3; i < free.mesh_node.size(); i += n) nodes.push_back(free.mesh_node[i]);
  return nodes;
}

TEST(Condensation, IsTheSameAsOneSolveForEachColumn) {
  const mesh::TetraMesh mesh = Box({7, 6, 8});
  const FreeNodes free = FindFreeNodes(mesh);
  std::vector<int> corridor;
  for (const int node : free.mesh_node) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(node);
    if ((x.head<2>() - Eigen::Vector2d(12, 12)).norm() < 7.0) corridor.push_back(node);
  }
  for (const std::vector<int>& reachable :
       {corridor, EveryNth(free, 9), EveryNth(free, 100000), free.mesh_node}) {
    const Compliance c = Condensed(mesh, free, reachable).Compliance(Storage::kDouble);
    const Eigen::MatrixXd exact = BySolves(mesh, free, reachable, reachable);
    ASSERT_TRUE(std::ranges::equal(c.nodes(), reachable));
    Eigen::MatrixXd got(exact.rows(), exact.cols());
    for (int i = 0; i < got.rows(); ++i) {
      for (int j = 0; j < got.cols(); ++j) got(i, j) = c.At(i, j);
    }
    EXPECT_LT(RelativeDifference(got, exact), 1e-12);
    EXPECT_EQ(got, got.transpose());
  }
}

TEST(Condensation, HoldsOverStiffnessesThatDifferByAThousand) {
  mesh::TetraMesh mesh = Box({6, 6, 6});
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    if (mesh.nodes_mm(0, mesh.tetrahedra(0, t)) > 12.0) mesh.tissue[t] = 3;
  }
  const FreeNodes free = FindFreeNodes(mesh);
  const std::vector<int> reachable = EveryNth(free, 7);
  const Compliance c = Condensed(mesh, free, reachable).Compliance(Storage::kDouble);
  const Eigen::MatrixXd exact = BySolves(mesh, free, reachable, reachable);
  for (int i = 0; i < exact.rows(); ++i) {
    EXPECT_NEAR(c.At(i, i), exact(i, i), 1e-11 * exact(i, i));
  }
}

TEST(Condensation, PartsThatOnlyFixedNodesJoinDoNotMoveEachOther) {
  mesh::TetraMesh mesh = Box({8, 4, 4});
  testing_support::Fix(
      mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0 || std::abs(x.x() - 16.0) < 3.0; });
  const FreeNodes free = FindFreeNodes(mesh);
  // Only the first part, only the second, and both.
  std::vector<int> left, right;
  for (const int node : EveryNth(free, 5)) {
    (mesh.nodes_mm(0, node) < 16.0 ? left : right).push_back(node);
  }
  for (const std::vector<int>& reachable : {left, right, EveryNth(free, 5)}) {
    const Compliance c = Condensed(mesh, free, reachable).Compliance(Storage::kDouble);
    const Eigen::MatrixXd exact = BySolves(mesh, free, reachable, reachable);
    double worst = 0.0;
    for (int i = 0; i < exact.rows(); ++i) {
      for (int j = 0; j < exact.cols(); ++j) {
        worst = std::max(worst, std::abs(c.At(i, j) - exact(i, j)));
      }
    }
    EXPECT_LT(worst, 1e-12 * exact.cwiseAbs().maxCoeff());
  }
}

TEST(Condensation, ImageColumnsAreTheDisplacementsOfVisibleNodes) {
  const mesh::TetraMesh mesh = Box({7, 7, 7});
  const FreeNodes free = FindFreeNodes(mesh);
  const std::vector<int> reachable = EveryNth(free, 13);
  Condensation condensed = Condensed(mesh, free, reachable);
  // Among them reachable ones; then few, so that most of the factor is not needed; then all.
  for (const std::vector<int>& visible :
       {EveryNth(free, 4), EveryNth(free, 150), reachable, free.mesh_node}) {
    condensed.SetVisible(visible);
    const Eigen::MatrixXd exact = BySolves(mesh, free, reachable, visible);
    Eigen::MatrixXf got(exact.rows(), exact.cols());
    const int split = 17;  // Pieces of different sizes, one after the other.
    condensed.ImageColumns(0, split, got.data());
    condensed.ImageColumns(split, static_cast<int>(got.cols()) - split, got.col(split).data());
    EXPECT_LT(RelativeDifference(got.cast<double>(), exact), 1e-7);
  }
}

TEST(Condensation, GivesTheSameBitsEachTime) {
  const mesh::TetraMesh mesh = Box({6, 6, 6});
  const FreeNodes free = FindFreeNodes(mesh);
  const std::vector<int> reachable = EveryNth(free, 6);
  const Condensation a = Condensed(mesh, free, reachable);
  const Condensation b = Condensed(mesh, free, reachable);
  for (int j = 0; j < 3 * static_cast<int>(reachable.size()); ++j) {
    EXPECT_TRUE(std::ranges::equal(a.ColumnMmPerN(j), b.ColumnMmPerN(j)));
  }
}

TEST(Condensation, NeedsNodesThatCanMove) {
  const mesh::TetraMesh mesh = Box({3, 3, 3});
  const FreeNodes free = FindFreeNodes(mesh);
  EXPECT_THAT([&] { Condensed(mesh, free, {}); },
              ThrowsMessage<InputError>(HasSubstr("no node to condense to")));
  EXPECT_THAT([&] { Condensed(mesh, free, {0}); },
              ThrowsMessage<InputError>(HasSubstr("node 0 is held in place")));
  EXPECT_THAT([&] { Condensed(mesh, free, {12345}); },
              ThrowsMessage<InputError>(HasSubstr("node 12345 is not one of")));
}

TEST(Condensation, SaysSoBeforeItTakesMoreMemoryThanAllowed) {
  const mesh::TetraMesh mesh = Box({8, 8, 8});
  const FreeNodes free = FindFreeNodes(mesh);
  EXPECT_THAT(
      [&] {
        Condensation(mesh, free, Table(), ElementKind::kLinear, free.mesh_node, 1.0, RunContext{});
      },
      ThrowsMessage<NoAnswerError>(HasSubstr("choose a narrower corridor")));
}

TEST(Condensation, StopsOnRequest) {
  const mesh::TetraMesh mesh = Box({3, 3, 3});
  const FreeNodes free = FindFreeNodes(mesh);
  const std::atomic<bool> stop{true};
  RunContext context;
  context.stop = &stop;
  EXPECT_THROW(Condensation(mesh, free, Table(), ElementKind::kLinear, free.mesh_node,
                            kDefaultMemoryMib, context),
               Cancelled);
}

}  // namespace
}  // namespace acus::mechanics
