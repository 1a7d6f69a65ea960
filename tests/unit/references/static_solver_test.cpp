#include "references/static_solver.h"

#include <gtest/gtest.h>

#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

class StaticSolverTest : public testing::TestWithParam<ElementKind> {
 protected:
  mesh::TetraMesh box_ = BoxMesh({3, 3, 4}, {0, 0, 0}, {30, 30, 40}, 0.15);
  ElasticityTable table_ = UniformTable(0.01, 0.45);
};
INSTANTIATE_TEST_SUITE_P(Elements, StaticSolverTest, testing::ValuesIn(kBothElements));

TEST_P(StaticSolverTest, ReactionsBalanceTheLoadInForceAndMoment) {
  Fix(box_, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Zero(3, box_.nodes_mm.cols());
  load.rightCols(5).colwise() = Eigen::Vector3d(1e-3, 2e-3, -3e-3);
  const StaticSolver solver(box_, table_, GetParam());
  const Eigen::Matrix3Xd all_n = solver.Forces(solver.Displacements(load));
  EXPECT_LT(all_n.rowwise().sum().norm(), 1e-12);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < all_n.cols(); ++i) {
    moment += box_.nodes_mm.col(i).cross(Eigen::Vector3d(all_n.col(i)));
  }
  EXPECT_LT(moment.norm(), 1e-11);
  for (const int node : solver.free().mesh_node) {
    EXPECT_LT((all_n - load).col(node).norm(), 1e-12);
  }
}

TEST_P(StaticSolverTest, LoadsAndHeldDisplacementsAdd) {
  Fix(box_, [](const Eigen::Vector3d& x) { return x.z() == 0.0 || x.z() == 40.0; });
  const StaticSolver solver(box_, table_, GetParam());
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, box_.nodes_mm.cols());
  const Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Constant(3, none.cols(), 1e-4);
  const Eigen::Matrix3Xd held = AtNodes(box_, [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(0.01 * x.z(), 0, x.z() > 0.0 ? -1.0 : 0.0);
  });
  const Eigen::Matrix3Xd both = solver.Displacements(load, held);
  const Eigen::Matrix3Xd sum = solver.Displacements(load) + solver.Displacements(none, held);
  EXPECT_LT((both - sum).norm(), 1e-12 * sum.norm());
  for (Eigen::Index i = 0; i < both.cols(); ++i) {
    const bool is_held = box_.fixed_nodes[static_cast<std::size_t>(i)] != 0;
    EXPECT_TRUE(!is_held || both.col(i) == held.col(i));
  }
}

}  // namespace
}  // namespace acus::mechanics
