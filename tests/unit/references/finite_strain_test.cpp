#include "references/finite_strain.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;
using testing::HasSubstr;
using testing::ThrowsMessage;

mesh::TetraMesh StrainedBlock() {
  mesh::TetraMesh box = BoxMesh({3, 3, 4}, {0, 0, 0}, {30, 30, 40}, 0.15);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return box;
}

Eigen::Matrix3d StrainedTurn() {
  return Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
}

/// Displacements of up to `size_mm` at random, of all nodes.
Eigen::Matrix3Xd SomeStrainedPlaces(const mesh::TetraMesh& mesh, double size_mm) {
  RandomStream random(7, "displacements");
  Eigen::Matrix3Xd u(3, mesh.nodes_mm.cols());
  for (double& value : u.reshaped()) value = size_mm * random.Uniform(-1.0, 1.0);
  return u;
}

class FiniteStrain : public testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements, FiniteStrain, testing::ValuesIn(kBothElements));

TEST_P(FiniteStrain, TurningAsAWholeNeedsNoForce) {
  const mesh::TetraMesh box = StrainedBlock();
  const FiniteStrainSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const Eigen::Matrix3Xd u =
      (StrainedTurn() * box.nodes_mm - box.nodes_mm).colwise() + Eigen::Vector3d(100, 20, -5);
  EXPECT_LT(solver.Forces(u).norm(), 1e-12);
  EXPECT_LT(solver.EnergyNmm(u), 1e-13);
}

TEST_P(FiniteStrain, ForcesTurnWithTheBody) {
  const mesh::TetraMesh box = StrainedBlock();
  const FiniteStrainSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const Eigen::Matrix3Xd u = SomeStrainedPlaces(box, 2.0);
  const Eigen::Matrix3Xd turned = StrainedTurn() * (box.nodes_mm + u) - box.nodes_mm;
  const Eigen::Matrix3Xd force_n = solver.Forces(u);
  EXPECT_LT((solver.Forces(turned) - StrainedTurn() * force_n).norm(), 1e-12 * force_n.norm());
  EXPECT_NEAR(solver.EnergyNmm(turned) / solver.EnergyNmm(u), 1.0, 1e-12);
}

TEST_P(FiniteStrain, ForcesAreTheSlopeOfTheEnergyAlsoInsideOut) {
  const mesh::TetraMesh box = StrainedBlock();
  const FiniteStrainSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  for (const double size_mm : {0.5, 12.0}) {  // 12 mm turns many of the tetrahedra inside out.
    const Eigen::Matrix3Xd u = SomeStrainedPlaces(box, size_mm);
    const Eigen::Matrix3Xd v = SomeStrainedPlaces(box, 1.0).rowwise().reverse();
    const double h = 1e-4;
    const double slope = (solver.EnergyNmm(u + h * v) - solver.EnergyNmm(u - h * v)) / (2.0 * h);
    const double work = solver.Forces(u).cwiseProduct(v).sum();
    EXPECT_NEAR(slope / work, 1.0, 1e-5) << size_mm;
  }
}

TEST_P(FiniteStrain, SmallLoadsGiveTheLinearSolution) {
  const mesh::TetraMesh box = StrainedBlock();
  const ElasticityTable table = UniformTable(0.01, 0.49);
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(1e-9, 0, -2e-9); });
  FiniteStrainSolver solver(box, table, GetParam());
  const FiniteStrainSolution solution = solver.Solve(load);
  const Eigen::Matrix3Xd linear = StaticSolver(box, table, GetParam()).Displacements(load);
  EXPECT_LT((solution.displacement_mm - linear).norm(), 1e-5 * linear.norm());
  EXPECT_EQ(solution.num_inverted, 0);
}

TEST_P(FiniteStrain, ATurnedAndStretchedBlockHasAConstantStrain) {
  mesh::TetraMesh box = StrainedBlock();
  FixSurface(box);
  Eigen::Matrix3d stretch;
  stretch << 1.1, 0.03, 0.0, 0.03, 0.95, -0.02, 0.0, -0.02, 1.05;
  const Eigen::Matrix3Xd exact = StrainedTurn() * stretch * box.nodes_mm - box.nodes_mm;
  FiniteStrainSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
  const FiniteStrainSolution solution = solver.Solve(none, exact);
  EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-7 * exact.norm());
}

TEST_P(FiniteStrain, AWarmStartEndsAtTheSameSolutionSooner) {
  const mesh::TetraMesh box = StrainedBlock();
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(8e-4, 0, -4e-4); });
  FiniteStrainSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const FiniteStrainSolution near = solver.Solve(0.98 * load);
  const FiniteStrainSolution cold = solver.Solve(load);
  const FiniteStrainSolution warm = solver.Solve(load, {}, near.displacement_mm);
  EXPECT_GT(cold.displacement_mm.colwise().norm().maxCoeff(), 3.0);
  EXPECT_LT(warm.num_iterations, cold.num_iterations);
  EXPECT_LT((warm.displacement_mm - cold.displacement_mm).norm(),
            1e-6 * cold.displacement_mm.norm());
}

TEST_P(FiniteStrain, RecoversFromATangleOfInvertedElements) {
  mesh::TetraMesh box = StrainedBlock();
  FiniteStrainSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  Eigen::Matrix3Xd tangle = SomeStrainedPlaces(box, 12.0);
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
  mesh::TetraMesh box = StrainedBlock();
  FixSurface(box);
  Eigen::Matrix3d gradient;
  gradient << 1.6, 0.5, 0.0, -0.2, 0.8, 0.1, 0.3, 0.0, 0.85;
  const Eigen::Matrix3Xd exact = StrainedTurn() * gradient * box.nodes_mm - box.nodes_mm;
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

TEST(FiniteStrainSolver, SaysWhenItDoesNotConverge) {
  const mesh::TetraMesh box = StrainedBlock();
  FiniteStrainSolver solver(box, UniformTable(0.01, 0.45), ElementKind::kLinear,
                            {.max_iterations = 1});
  const Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Constant(3, box.nodes_mm.cols(), 0.01);
  EXPECT_THAT([&] { solver.Solve(load); },
              ThrowsMessage<NoAnswerError>(HasSubstr("did not converge: after 1 iterations")));
}

}  // namespace
}  // namespace acus::mechanics
