// What both solvers for large rotations have in common: the corotational one and that of finite
// strain.
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "references/corotational.h"
#include "references/finite_strain.h"
#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/turned_block.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;
using testing::HasSubstr;
using testing::ThrowsMessage;

template <class SolverOf, ElementKind kElement>
struct SolverWithElement {
  using Solver = SolverOf;
  static constexpr ElementKind kKind = kElement;
};

template <class Case>
class LargeRotations : public testing::Test {};
using LargeRotationCases =
    testing::Types<SolverWithElement<CorotationalSolver, ElementKind::kLinear>,
                   SolverWithElement<CorotationalSolver, ElementKind::kAveragedDilatation>,
                   SolverWithElement<FiniteStrainSolver, ElementKind::kLinear>,
                   SolverWithElement<FiniteStrainSolver, ElementKind::kAveragedDilatation>>;
TYPED_TEST_SUITE(LargeRotations, LargeRotationCases);

TYPED_TEST(LargeRotations, TurningAsAWholeNeedsNoForce) {
  const mesh::TetraMesh box = Block();
  const typename TypeParam::Solver solver(box, UniformTable(0.01, 0.49), TypeParam::kKind);
  const Eigen::Matrix3Xd u =
      (Turn() * box.nodes_mm - box.nodes_mm).colwise() + Eigen::Vector3d(100, 20, -5);
  EXPECT_LT(solver.Forces(u).norm(), 1e-12);
  EXPECT_LT(solver.EnergyNmm(u), 1e-13);
}

TYPED_TEST(LargeRotations, ForcesTurnWithTheBody) {
  const mesh::TetraMesh box = Block();
  const typename TypeParam::Solver solver(box, UniformTable(0.01, 0.49), TypeParam::kKind);
  const Eigen::Matrix3Xd u = SomeDisplacements(box, 2.0);
  const Eigen::Matrix3Xd turned = Turn() * (box.nodes_mm + u) - box.nodes_mm;
  const Eigen::Matrix3Xd force_n = solver.Forces(u);
  EXPECT_LT((solver.Forces(turned) - Turn() * force_n).norm(), 1e-12 * force_n.norm());
  EXPECT_NEAR(solver.EnergyNmm(turned) / solver.EnergyNmm(u), 1.0, 1e-12);
}

TYPED_TEST(LargeRotations, ForcesAreTheSlopeOfTheEnergyAlsoInsideOut) {
  const mesh::TetraMesh box = Block();
  const typename TypeParam::Solver solver(box, UniformTable(0.01, 0.45), TypeParam::kKind);
  for (const double size_mm : {0.5, 12.0}) {  // 12 mm turns many of the tetrahedra inside out.
    const Eigen::Matrix3Xd u = SomeDisplacements(box, size_mm);
    const Eigen::Matrix3Xd v = SomeDisplacements(box, 1.0).rowwise().reverse();
    const double h = 1e-4;
    const double slope = (solver.EnergyNmm(u + h * v) - solver.EnergyNmm(u - h * v)) / (2.0 * h);
    const double work = solver.Forces(u).cwiseProduct(v).sum();
    EXPECT_NEAR(slope / work, 1.0, 1e-5) << size_mm;
  }
}

TYPED_TEST(LargeRotations, SmallLoadsGiveTheLinearSolution) {
  const mesh::TetraMesh box = Block();
  const ElasticityTable table = UniformTable(0.01, 0.49);
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(1e-9, 0, -2e-9); });
  typename TypeParam::Solver solver(box, table, TypeParam::kKind);
  const auto solution = solver.Solve(load);
  const Eigen::Matrix3Xd linear = StaticSolver(box, table, TypeParam::kKind).Displacements(load);
  EXPECT_LT((solution.displacement_mm - linear).norm(), 1e-5 * linear.norm());
  EXPECT_EQ(solution.num_inverted, 0);
}

TYPED_TEST(LargeRotations, ATurnedAndStretchedBlockHasAConstantStrain) {
  mesh::TetraMesh box = Block();
  FixSurface(box);
  Eigen::Matrix3d stretch;
  stretch << 1.1, 0.03, 0.0, 0.03, 0.95, -0.02, 0.0, -0.02, 1.05;
  const Eigen::Matrix3Xd exact = Turn() * stretch * box.nodes_mm - box.nodes_mm;
  typename TypeParam::Solver solver(box, UniformTable(0.01, 0.45), TypeParam::kKind);
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
  const auto solution = solver.Solve(none, exact);
  EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-7 * exact.norm());
}

TYPED_TEST(LargeRotations, AWarmStartEndsAtTheSameSolutionSooner) {
  const mesh::TetraMesh box = Block();
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(8e-4, 0, -4e-4); });
  typename TypeParam::Solver solver(box, UniformTable(0.01, 0.49), TypeParam::kKind);
  const auto near = solver.Solve(0.98 * load);
  const auto cold = solver.Solve(load);
  const auto warm = solver.Solve(load, {}, near.displacement_mm);
  EXPECT_GT(cold.displacement_mm.colwise().norm().maxCoeff(), 3.0);
  EXPECT_LT(warm.num_iterations, cold.num_iterations);
  EXPECT_LT((warm.displacement_mm - cold.displacement_mm).norm(),
            1e-6 * cold.displacement_mm.norm());
}

TYPED_TEST(LargeRotations, SaysWhenItDoesNotConverge) {
  const mesh::TetraMesh box = Block();
  typename TypeParam::Solver solver(box, UniformTable(0.01, 0.45), TypeParam::kKind,
                                    {.max_iterations = 1});
  const Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Constant(3, box.nodes_mm.cols(), 0.01);
  EXPECT_THAT([&] { solver.Solve(load); },
              ThrowsMessage<NoAnswerError>(HasSubstr("did not converge: after 1 iterations")));
}

}  // namespace
}  // namespace acus::mechanics
