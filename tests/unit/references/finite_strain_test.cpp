#include "references/finite_strain.h"

#include <gtest/gtest.h>

#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/turned_block.h"

// What both solvers for large rotations have in common is in large_rotations_test.cpp.
namespace acus::mechanics {
namespace {

using namespace testing_support;

class FiniteStrain : public testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements, FiniteStrain, testing::ValuesIn(kBothElements));

TEST_P(FiniteStrain, RecoversFromATangleOfInvertedElements) {
  mesh::TetraMesh box = Block();
  FiniteStrainSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  Eigen::Matrix3Xd tangle = SomeDisplacements(box, 12.0);
  for (Eigen::Index i = 0; i < tangle.cols(); ++i) {
    if (box.fixed_nodes[static_cast<std::size_t>(i)]) tangle.col(i).setZero();
  }
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, tangle.cols());
  const FiniteStrainSolution solution = solver.Solve(none, {}, tangle);
  EXPECT_LT(solver.EnergyNmm(solution.displacement_mm), solver.EnergyNmm(tangle));
  // Meshes of single tetrahedra have tangled equilibria; with averaged volume this one has not.
  if (GetParam() == ElementKind::kLinear) return;
  EXPECT_LT(solution.displacement_mm.norm(), 1e-4);
  EXPECT_EQ(solution.num_inverted, 0);
}

TEST_P(FiniteStrain, ConstantStrainIsKeptByEveryLaw) {
  mesh::TetraMesh box = Block();
  FixSurface(box);
  Eigen::Matrix3d gradient;
  gradient << 1.6, 0.5, 0.0, -0.2, 0.8, 0.1, 0.3, 0.0, 0.85;
  const Eigen::Matrix3Xd exact = Turn() * gradient * box.nodes_mm - box.nodes_mm;
  for (const HyperelasticLaw& law :
       {HyperelasticLaw{}, HyperelasticLaw{LawKind::kYeoh, 1e-3, 1e-3, 0.0},
        HyperelasticLaw{LawKind::kFung, 0.0, 0.0, 2.0}}) {
    ElasticityTable table = UniformTable(0.01, 0.49);
    table.law.fill(law);
    FiniteStrainSolver solver(box, table, GetParam());
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
    const FiniteStrainSolution solution = solver.Solve(none, exact);
    EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-8 * exact.norm()) << LawName(law.kind);
  }
}

}  // namespace
}  // namespace acus::mechanics
