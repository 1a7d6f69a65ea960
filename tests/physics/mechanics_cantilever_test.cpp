// A clamped beam under a force at its end, against beam theory with shear.
#include <gtest/gtest.h>

#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

/// Deflection of the end's middle over that of a Timoshenko beam.
double DeflectionRatio(ElementKind kind, double poissons_ratio, int cells) {
  constexpr double kLength = 80.0;
  constexpr double kSide = 10.0;
  constexpr double kEMpa = 0.05;
  constexpr double kForceN = 1e-3;
  mesh::TetraMesh beam =
      BoxMesh({8 * cells, cells / 3, cells}, {0, 0, 0}, {kLength, kSide, kSide}, 0.1);
  Fix(beam, [](const Eigen::Vector3d& x) { return x.x() == 0.0; });
  const Eigen::Matrix3Xd load = TractionLoad(
      beam, [](const Eigen::Vector3d& x) { return x.x() == kLength; },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, -kForceN / (kSide * kSide)); });
  const Eigen::Matrix3Xd u =
      StaticSolver(beam, UniformTable(kEMpa, poissons_ratio), kind).Displacements(load);
  // Work of the load over its force: the mean deflection of the end.
  const double deflection_mm = load.cwiseProduct(u).sum() / kForceN;
  const double second_moment_mm4 = std::pow(kSide, 4) / 12.0;
  // Cowper 1966: shear coefficient of a rectangle.
  const double kappa = 10.0 * (1.0 + poissons_ratio) / (12.0 + 11.0 * poissons_ratio);
  const double g_mpa = kEMpa / (2.0 * (1.0 + poissons_ratio));
  const double beam_mm = kForceN * std::pow(kLength, 3) / (3.0 * kEMpa * second_moment_mm4) +
                         kForceN * kLength / (kappa * g_mpa * kSide * kSide);
  return deflection_mm / beam_mm;
}

TEST(MechanicsCantilever, BendsAsABeam) {
  for (const ElementKind kind : kBothElements) {
    EXPECT_NEAR(DeflectionRatio(kind, 0.3, 18), 1.0, 0.03) << static_cast<int>(kind);
  }
}

TEST(MechanicsCantilever, DoesNotLockWhenNearlyIncompressible) {
  // Beam theory lets the clamped end contract, the clamp does not: part of what is missing.
  EXPECT_NEAR(DeflectionRatio(ElementKind::kAveragedDilatation, 0.499, 18), 1.0, 0.05);
  EXPECT_LT(DeflectionRatio(ElementKind::kLinear, 0.499, 9), 0.5);  // It locks.
}

}  // namespace
}  // namespace acus::mechanics
