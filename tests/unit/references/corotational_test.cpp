#include "references/corotational.h"

#include <gtest/gtest.h>

#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/turned_block.h"

// What both solvers for large rotations have in common is in large_rotations_test.cpp.
namespace acus::mechanics {
namespace {

using namespace testing_support;

class Corotational : public testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements, Corotational, testing::ValuesIn(kBothElements));

TEST_P(Corotational, RecoversFromATangleOfInvertedElements) {
  mesh::TetraMesh box = Block();
  CorotationalSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  Eigen::Matrix3Xd tangle = SomeDisplacements(box, 12.0);
  for (Eigen::Index i = 0; i < tangle.cols(); ++i) {
    if (box.fixed_nodes[static_cast<std::size_t>(i)]) tangle.col(i).setZero();
  }
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, tangle.cols());
  const CorotationalSolution solution = solver.Solve(none, {}, tangle);
  EXPECT_LT(solution.displacement_mm.norm(), 1e-4);
  EXPECT_EQ(solution.num_inverted, 0);
}

}  // namespace
}  // namespace acus::mechanics
