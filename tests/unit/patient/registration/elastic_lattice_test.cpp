#include "acus/patient/registration/elastic_lattice.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Eigen::AlignedBox3d Box() {
  return {Vector3d(-20, -10, 0), Vector3d(20, 30, 50)};
}

/// Springs that hold all three coordinates of places to an affine displacement.
std::vector<Spring> Held(const Matrix3d& gradient, const Vector3d& shift_mm, bool border_only) {
  std::vector<Spring> springs;
  const LatticeField lattice(Box(), 5.0);
  for (int k = 0; k < lattice.size()[2]; ++k) {
    for (int j = 0; j < lattice.size()[1]; ++j) {
      for (int i = 0; i < lattice.size()[0]; ++i) {
        const Eigen::Array3i at(i, j, k);
        const bool border = (at == 0).any() || (at == lattice.size() - 1).any();
        if (border_only && !border) continue;
        const Vector3d x_mm = lattice.PlaceMm(i, j, k);
        const Vector3d u_mm = gradient * x_mm + shift_mm;
        for (int axis = 0; axis < 3; ++axis) {
          springs.push_back({.rest_mm = x_mm,
                             .direction = Vector3d::Unit(axis),
                             .pull_mm = u_mm[axis],
                             .stiffness = 1e4});
        }
      }
    }
  }
  return springs;
}

TEST(LatticeField, IsTrilinear) {
  LatticeField field(Box(), 5.0);
  Matrix3d gradient;
  gradient << 0.01, 0.02, -0.03, 0.04, -0.01, 0.02, 0.0, 0.03, 0.05;
  for (int k = 0; k < field.size()[2]; ++k) {
    for (int j = 0; j < field.size()[1]; ++j) {
      for (int i = 0; i < field.size()[0]; ++i) {
        field.nodes_mm()[field.Index(i, j, k)] = gradient * field.PlaceMm(i, j, k);
      }
    }
  }
  const Vector3d x_mm(3.3, 17.1, 41.7);
  EXPECT_LT((field.At(x_mm) - gradient * x_mm).norm(), 1e-12);
  EXPECT_LT((field.GradientAt(x_mm) - Matrix3d::Identity() - gradient).norm(), 1e-12);
  EXPECT_LT((field.At({1000, 0, 0}) - field.At({20, 0, 0})).norm(), 1e-12);  // As at the border.
}

// The patch test: a uniform strain at the border is the strain everywhere.
TEST(ElasticLattice, PassesThePatchTest) {
  Matrix3d gradient;
  gradient << 0.01, 0.02, -0.03, 0.04, -0.01, 0.02, 0.0, 0.03, 0.05;
  const Vector3d shift_mm(1, -2, 3);
  LatticeField field(Box(), 5.0);
  const ElasticLattice body(
      field, [](const Vector3d&) { return 1.0; }, 1);
  EXPECT_LT(body.Solve(Held(gradient, shift_mm, true), field, 1), 2000);
  for (int i = 1; i < 8; ++i) {
    const Vector3d x_mm(4.0 * i - 17, 3.0 * i, 5.0 * i + 2);
    EXPECT_LT((field.At(x_mm) - gradient * x_mm - shift_mm).norm(), 2e-3);
  }
}

// A bar of two materials in series, pulled at its ends and free to contract at its sides: strains
// are as the inverse of the moduli.
TEST(ElasticLattice, SharesStrainByStiffness) {
  LatticeField field({Vector3d(0, 0, 0), Vector3d(200, 20, 20)}, 10.0);
  const ElasticLattice body(
      field, [](const Vector3d& x) { return x.x() < 100 ? 1.0 : 4.0; }, 1);
  std::vector<Spring> springs;
  for (const double x : {0.0, 200.0}) {
    for (const double y : {0.0, 10.0, 20.0}) {
      for (const double z : {0.0, 10.0, 20.0}) {
        springs.push_back({.rest_mm = {x, y, z},
                           .direction = Vector3d::UnitX(),
                           .pull_mm = x / 200.0,
                           .stiffness = 1e4});
      }
    }
  }
  body.Solve(springs, field, 1);
  const double soft = (field.At({80, 10, 10}).x() - field.At({20, 10, 10}).x()) / 60.0;
  const double stiff = (field.At({180, 10, 10}).x() - field.At({120, 10, 10}).x()) / 60.0;
  EXPECT_NEAR(soft / stiff, 4.0, 0.1);
  EXPECT_NEAR(soft * 100 + stiff * 100, 1.0, 0.03);
  const double across = field.At({50, 20, 10}).y() - field.At({50, 0, 10}).y();
  EXPECT_NEAR(across / 20.0, -0.3 * soft, 0.02 * soft);  // Poisson.
}

// A block held at its bottom and pulled aside at its top by springs as stiff as itself gives half
// of the way. In simple shear its stiffness is G area / height, G = E / (2 (1 + 0.3)).
TEST(ElasticLattice, ShearsByTheShearModulus) {
  LatticeField field({Vector3d::Zero(), Vector3d(20, 20, 30)}, 5.0);
  const ElasticLattice body(
      field, [](const Vector3d&) { return 1.0; }, 1);
  const Eigen::Array3i last = field.size() - 1;
  const double stiffness = 1.0 / 2.6 * 20.0 * 20.0 / 30.0;
  std::vector<Spring> springs;
  for (int k = 0; k <= last[2]; ++k) {
    for (int j = 0; j <= last[1]; ++j) {
      for (int i = 0; i <= last[0]; ++i) {
        const Vector3d x_mm = field.PlaceMm(i, j, k);
        for (int axis = k == 0 ? 0 : 1; axis < 3; ++axis) {
          springs.push_back({.rest_mm = x_mm, .direction = Vector3d::Unit(axis), .stiffness = 1e4});
        }
        if (k != last[2]) continue;
        // Nodes at the sides have half of a face, those at corners a quarter.
        const double share = (i % last[0] == 0 ? 0.5 : 1.0) * (j % last[1] == 0 ? 0.5 : 1.0) / 16.0;
        springs.push_back({.rest_mm = x_mm,
                           .direction = Vector3d::UnitX(),
                           .pull_mm = 1.0,
                           .stiffness = share * stiffness});
      }
    }
  }
  body.Solve(springs, field, 1);
  EXPECT_NEAR(field.At({10, 10, 30}).x(), 0.5, 0.005);
  EXPECT_NEAR(field.At({3, 17, 15}).x(), 0.25, 0.005);
}

TEST(ElasticLattice, DoesNotDependOnThreads) {
  RandomStream random(1, "springs");
  std::vector<Spring> springs;
  for (int i = 0; i < 60; ++i) {
    springs.push_back({.rest_mm = Box().min() + Box().diagonal() * random.Uniform(),
                       .direction = Vector3d(random.Normal(), random.Normal(), 1).normalized(),
                       .pull_mm = random.Normal(),
                       .stiffness = 5.0});
  }
  LatticeField a(Box(), 5.0), b(Box(), 5.0);
  const auto modulus = [](const Vector3d& x) { return x.x() > 0 ? 100.0 : 1.0; };
  ElasticLattice(a, modulus, 1).Solve(springs, a, 1);
  ElasticLattice(b, modulus, 3).Solve(springs, b, 3);
  EXPECT_EQ(a.nodes_mm(), b.nodes_mm());
}

}  // namespace
}  // namespace acus::registration
