// A slender cantilever bent far, against the elastica; and what the linear model makes of it.
#include <gtest/gtest.h>

#include "references/corotational.h"
#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

/// Mattiasson 1981, by elliptic integrals: load P L^2 / (E I), and how far the end goes down and
/// back, over the length.
struct Elastica {
  double load, down, back;
};
constexpr Elastica kElasticas[] = {
    {1.0, 0.30172, 0.05643}, {2.0, 0.49346, 0.16064}, {5.0, 0.71379, 0.38763}};
constexpr double kLengthMm = 100.0;
constexpr double kHeightMm = 4.0;

mesh::TetraMesh Strip() {
  mesh::TetraMesh strip = BoxMesh({100, 2, 8}, {0, 0, 0}, {kLengthMm, 2, kHeightMm}, 0.1);
  Fix(strip, [](const Eigen::Vector3d& x) { return x.x() == 0.0; });
  return strip;
}

TEST(MechanicsElastica, CorotationalStripBendsAsTheElastica) {
  const mesh::TetraMesh strip = Strip();
  const ElasticityTable table = UniformTable(0.05, 0.3);
  const Eigen::Matrix3Xd shape = TractionLoad(
      strip, [](const Eigen::Vector3d& x) { return x.x() == kLengthMm; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, -1.0 / (2.0 * kHeightMm)); });
  for (const ElementKind kind : kBothElements) {
    // The mesh's own stiffness in bending, from a load so small that both models agree: what is
    // left to see is the turning. The mesh's error in bending is the cantilever test's.
    const double flexibility =
        shape.cwiseProduct(StaticSolver(strip, table, kind).Displacements(shape)).sum();
    const double bending_n_mm2 = std::pow(kLengthMm, 3) / (3.0 * flexibility);
    CorotationalSolver solver(strip, table, kind);
    Eigen::Matrix3Xd u;
    for (const auto& [load, down, back] : kElasticas) {
      const double force_n = load * bending_n_mm2 / (kLengthMm * kLengthMm);
      const CorotationalSolution solution = solver.Solve(force_n * shape, {}, u);
      u = solution.displacement_mm;
      const Eigen::Matrix3Xd weights = shape.row(2).replicate(3, 1);
      const Eigen::Vector3d end_mm = -u.cwiseProduct(weights).rowwise().sum();
      EXPECT_NEAR(-end_mm.z() / kLengthMm, down, 0.005) << load;
      EXPECT_NEAR(-end_mm.x() / kLengthMm, back, 0.005) << load;
      EXPECT_EQ(solution.num_inverted, 0);
      // The linear model goes down without end and never back.
      EXPECT_GT(load / 3.0, down);
      RecordProperty("iterations_" + std::to_string(static_cast<int>(load)) +
                         (kind == ElementKind::kLinear ? "_linear" : "_averaged"),
                     solution.num_iterations);
    }
  }
}

TEST(MechanicsElastica, ATwistedEndTurnsTheStripEvenly) {
  mesh::TetraMesh strip = BoxMesh({40, 4, 4}, {0, -2, -2}, {40, 2, 2}, 0.1);
  Fix(strip, [](const Eigen::Vector3d& x) { return x.x() == 0.0 || x.x() == 40.0; });
  const auto turned = [](double angle) {
    return [angle](const Eigen::Vector3d& x) {
      const Eigen::AngleAxisd turn(angle * x.x() / 40.0, Eigen::Vector3d::UnitX());
      return Eigen::Vector3d(turn * x - x);
    };
  };
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, strip.nodes_mm.cols());
  for (const ElementKind kind : kBothElements) {
    CorotationalSolver solver(strip, UniformTable(0.05, 0.3), kind);
    Eigen::Matrix3Xd u;
    for (const double angle : {0.5, 1.0, 1.5}) {  // rad, each from the one before.
      u = solver.Solve(none, AtNodes(strip, turned(angle)), u).displacement_mm;
    }
    // Half way along the strip has turned by half; a strip that turns is a little shorter.
    const Eigen::Matrix3Xd even = AtNodes(strip, turned(1.5));
    EXPECT_LT((u - even).norm(), 0.03 * even.norm());
  }
}

}  // namespace
}  // namespace acus::mechanics
