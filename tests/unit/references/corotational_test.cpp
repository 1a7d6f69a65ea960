#include "references/corotational.h"

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

mesh::TetraMesh Block() {
  mesh::TetraMesh box = BoxMesh({3, 3, 4}, {0, 0, 0}, {30, 30, 40}, 0.15);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return box;
}

Eigen::Matrix3d Turn() {
  return Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
}

/// Displacements of up to `size_mm` at random, of all nodes.
Eigen::Matrix3Xd SomeDisplacements(const mesh::TetraMesh& mesh, double size_mm) {
  RandomStream random(7, "displacements");
  Eigen::Matrix3Xd u(3, mesh.nodes_mm.cols());
  for (double& value : u.reshaped()) value = size_mm * random.Uniform(-1.0, 1.0);
  return u;
}

class Corotational : public testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements, Corotational, testing::ValuesIn(kBothElements));

TEST_P(Corotational, TurningAsAWholeNeedsNoForce) {
  const mesh::TetraMesh box = Block();
  const CorotationalSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const Eigen::Matrix3Xd u =
      (Turn() * box.nodes_mm - box.nodes_mm).colwise() + Eigen::Vector3d(100, 20, -5);
  EXPECT_LT(solver.Forces(u).norm(), 1e-12);
  EXPECT_LT(solver.EnergyNmm(u), 1e-13);
}

TEST_P(Corotational, ForcesTurnWithTheBody) {
  const mesh::TetraMesh box = Block();
  const CorotationalSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const Eigen::Matrix3Xd u = SomeDisplacements(box, 2.0);
  const Eigen::Matrix3Xd turned = Turn() * (box.nodes_mm + u) - box.nodes_mm;
  const Eigen::Matrix3Xd force_n = solver.Forces(u);
  EXPECT_LT((solver.Forces(turned) - Turn() * force_n).norm(), 1e-12 * force_n.norm());
  EXPECT_NEAR(solver.EnergyNmm(turned) / solver.EnergyNmm(u), 1.0, 1e-12);
}

TEST_P(Corotational, ForcesAreTheSlopeOfTheEnergyAlsoInsideOut) {
  const mesh::TetraMesh box = Block();
  const CorotationalSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  for (const double size_mm : {0.5, 12.0}) {  // 12 mm turns many of the tetrahedra inside out.
    const Eigen::Matrix3Xd u = SomeDisplacements(box, size_mm);
    const Eigen::Matrix3Xd v = SomeDisplacements(box, 1.0).rowwise().reverse();
    const double h = 1e-4;
    const double slope = (solver.EnergyNmm(u + h * v) - solver.EnergyNmm(u - h * v)) / (2.0 * h);
    const double work = solver.Forces(u).cwiseProduct(v).sum();
    EXPECT_NEAR(slope / work, 1.0, 1e-5) << size_mm;
  }
}

TEST_P(Corotational, SmallLoadsGiveTheLinearSolution) {
  const mesh::TetraMesh box = Block();
  const ElasticityTable table = UniformTable(0.01, 0.49);
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(1e-9, 0, -2e-9); });
  CorotationalSolver solver(box, table, GetParam());
  const CorotationalSolution solution = solver.Solve(load);
  const Eigen::Matrix3Xd linear = StaticSolver(box, table, GetParam()).Displacements(load);
  EXPECT_LT((solution.displacement_mm - linear).norm(), 1e-5 * linear.norm());
  EXPECT_EQ(solution.num_inverted, 0);
}

TEST_P(Corotational, ATurnedAndStretchedBlockHasAConstantStrain) {
  mesh::TetraMesh box = Block();
  FixSurface(box);
  Eigen::Matrix3d stretch;
  stretch << 1.1, 0.03, 0.0, 0.03, 0.95, -0.02, 0.0, -0.02, 1.05;
  const Eigen::Matrix3Xd exact = Turn() * stretch * box.nodes_mm - box.nodes_mm;
  CorotationalSolver solver(box, UniformTable(0.01, 0.45), GetParam());
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
  const CorotationalSolution solution = solver.Solve(none, exact);
  EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-7 * exact.norm());
}

TEST_P(Corotational, AWarmStartEndsAtTheSameSolutionSooner) {
  const mesh::TetraMesh box = Block();
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(8e-4, 0, -4e-4); });
  CorotationalSolver solver(box, UniformTable(0.01, 0.49), GetParam());
  const CorotationalSolution near = solver.Solve(0.98 * load);
  const CorotationalSolution cold = solver.Solve(load);
  const CorotationalSolution warm = solver.Solve(load, {}, near.displacement_mm);
  EXPECT_GT(cold.displacement_mm.colwise().norm().maxCoeff(), 3.0);
  EXPECT_LT(warm.num_iterations, cold.num_iterations);
  EXPECT_LT((warm.displacement_mm - cold.displacement_mm).norm(),
            1e-6 * cold.displacement_mm.norm());
}

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

TEST(CorotationalSolver, SaysWhenItDoesNotConverge) {
  const mesh::TetraMesh box = Block();
  CorotationalSolver solver(box, UniformTable(0.01, 0.45), ElementKind::kLinear,
                            {.max_iterations = 1});
  const Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Constant(3, box.nodes_mm.cols(), 0.01);
  EXPECT_THAT([&] { solver.Solve(load); },
              ThrowsMessage<NoAnswerError>(HasSubstr("did not converge: after 1 iterations")));
}

}  // namespace
}  // namespace acus::mechanics
