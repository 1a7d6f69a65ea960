// Hard cases of large strain: the answer is finite, or there is none and it says so.
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "references/finite_strain.h"
#include "support/bound.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

mesh::TetraMesh HeldBlock() {
  mesh::TetraMesh box = BoxMesh({3, 3, 4}, {0, 0, 0}, {30, 30, 40}, 0.15);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return box;
}

ElasticityTable StiffeningTable(double exponent_b) {
  ElasticityTable table = UniformTable(0.01, 0.49);
  if (exponent_b > 0.0) table.law.fill({LawKind::kFung, 0.0, 0.0, exponent_b});
  return table;
}

/// In a number of parts, each from the last. @return  Whether there was an answer to all.
bool SolvedInParts(FiniteStrainSolver& solver, const Eigen::Matrix3Xd& load_n,
                   const Eigen::Matrix3Xd& held_mm, int parts, FiniteStrainSolution& solution) {
  for (int n = 1; n <= parts; ++n) {
    const double share = static_cast<double>(n) / parts;
    try {
      solution = solver.Solve(share * load_n, share * held_mm, solution.displacement_mm);
    } catch (const NoAnswerError&) {
      return false;
    }
  }
  return true;
}

TEST(FiniteStrainStability, PulledToFourTimesItsLength) {
  const HardCase hard(
      "A block held at one end is pulled by the other until it is 4 times as long.");
  for (const ElementKind kind : kBothElements) {
    mesh::TetraMesh box = HeldBlock();
    Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0 || x.z() == 40.0; });
    Eigen::Matrix3Xd held = Eigen::Matrix3Xd::Zero(3, box.nodes_mm.cols());
    for (Eigen::Index i = 0; i < held.cols(); ++i) {
      if (box.nodes_mm(2, i) == 40.0) held(2, i) = 120.0;
    }
    FiniteStrainSolver solver(box, StiffeningTable(0.2), kind);
    FiniteStrainSolution solution;
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, held.cols());
    ASSERT_TRUE(SolvedInParts(solver, none, held, 12, solution));
    hard.Expect("tetrahedra inside out", solution.num_inverted, Exactly(0), "");
    hard.Expect("largest stretch", solution.largest_stretch, AtLeast(4.0), "");
    hard.Expect("largest stretch, bound", solution.largest_stretch, AtMost(10.0), "");
  }
}

TEST(FiniteStrainStability, HugeLoadsHaveAnAnswerOrSayThatThereIsNone) {
  const HardCase hard("Loads of up to a million times what tissue bears, with every law.");
  int answers = 0, refusals = 0;
  for (const ElementKind kind : kBothElements) {
    for (const double exponent_b : {0.0, 1.0, 30.0}) {
      for (const double traction_mpa : {1e-3, 1e-1, 1e1, 1e3, 1e12}) {
        const mesh::TetraMesh box = HeldBlock();
        const Eigen::Matrix3Xd load = TractionLoad(
            box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
            [&](const Eigen::Vector3d&) {
              return Eigen::Vector3d(0.4 * traction_mpa, 0, -traction_mpa);
            });
        FiniteStrainSolver solver(box, StiffeningTable(exponent_b), kind, {.max_iterations = 60});
        try {
          const FiniteStrainSolution solution = solver.Solve(load);
          EXPECT_TRUE(solution.displacement_mm.allFinite());
          EXPECT_TRUE(std::isfinite(solver.EnergyNmm(solution.displacement_mm)));
          ++answers;
        } catch (const NoAnswerError&) {
          ++refusals;
        }
      }
    }
  }
  hard.Expect("answers", answers, AtLeast(6), "");
  hard.Expect("answers and refusals", answers + refusals, Exactly(30), "");
}

TEST(FiniteStrainStability, FlattenedAndInvertedStartsComeBack) {
  const HardCase hard(
      "The solution begins where the mesh is flat, or a tangle of inverted elements.");
  const mesh::TetraMesh box = HeldBlock();
  FiniteStrainSolver solver(box, StiffeningTable(2.0), ElementKind::kAveragedDilatation);
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, box.nodes_mm.cols());
  Eigen::Matrix3Xd flat = none;
  flat.row(2) = -box.nodes_mm.row(2);
  hard.Expect("displacement left, from flat",
              solver.Solve(none, {}, flat).displacement_mm.cwiseAbs().maxCoeff(), AtMost(1e-4),
              "mm");
  RandomStream random(9, "tangle");
  Eigen::Matrix3Xd tangle = none;
  for (Eigen::Index i = 0; i < tangle.cols(); ++i) {
    if (box.fixed_nodes[static_cast<std::size_t>(i)]) continue;
    for (int axis = 0; axis < 3; ++axis) tangle(axis, i) = 8.0 * random.Uniform(-1.0, 1.0);
  }
  hard.Expect("displacement left, from a tangle",
              solver.Solve(none, {}, tangle).displacement_mm.cwiseAbs().maxCoeff(), AtMost(1e-4),
              "mm");
}

TEST(FiniteStrainStability, AThousandToOneAndNearlyNoChangeOfVolume) {
  const HardCase hard(
      "A hard layer, 1000 times as stiff, between soft ones, Poisson's ratio 0.4999.");
  mesh::TetraMesh box = HeldBlock();
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    double z = 0.0;
    for (int c = 0; c < 4; ++c) z += 0.25 * box.nodes_mm(2, box.tetrahedra(c, static_cast<int>(t)));
    box.tissue[t] = z > 10.0 && z < 20.0 ? 2 : 1;
  }
  ElasticityTable table = UniformTable(0.005, 0.4999);
  table.tissue[2].youngs_modulus_mpa = 5.0;
  table.law.fill({LawKind::kFung, 0.0, 0.0, 2.0});
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 40.0; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(5e-4, 0, -2e-3); });
  FiniteStrainSolver solver(box, table, ElementKind::kAveragedDilatation);
  FiniteStrainSolution solution;
  ASSERT_TRUE(SolvedInParts(solver, load, Eigen::Matrix3Xd::Zero(3, load.cols()), 4, solution));
  hard.Expect("tetrahedra inside out", solution.num_inverted, Exactly(0), "");
  hard.Expect("top moves by", solution.displacement_mm.cwiseAbs().maxCoeff(), AtLeast(2.0), "mm");
  hard.Expect("top moves by no more than", solution.displacement_mm.cwiseAbs().maxCoeff(),
              AtMost(30.0), "mm");
}

}  // namespace
}  // namespace acus::mechanics
