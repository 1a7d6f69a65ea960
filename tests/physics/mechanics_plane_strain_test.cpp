// The plane-strain triangles against closed forms and against themselves on a finer grid.
#include <Eigen/SparseCholesky>
#include <cmath>
#include <cstdio>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/physics/mechanics/elements/plane_strain.h"

namespace acus::mechanics {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// Solves with the nodes held that `held` says; forces per mm of thickness.
VectorXd Deform(const PlaneGrid& grid, const ElasticTissue& tissue, Dilatation dilatation,
                const std::function<bool(const Vector2d&)>& held, const VectorXd& force) {
  const std::vector<ElasticTissue> all(grid.num_triangles(), tissue);
  Eigen::SparseMatrix<double> k = PlaneStiffness(grid, all, dilatation);
  VectorXd load = force;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    if (!held(grid.PositionMm(n))) continue;
    for (const int i : {2 * n, 2 * n + 1}) {
      k.coeffRef(i, i) += 1e9 * tissue.youngs_modulus_mpa;
      load[i] = 0.0;
    }
  }
  return Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>(k).solve(load);
}

// Timoshenko: P L^3 / (3 E' I) + 6 P L / (5 G H), with E' = E / (1 - nu^2) in plane strain.
/// Deflection of the end of a cantilever, 200 x 20 mm, over that of the beam.
double CantileverOverBeam(double spacing_mm, double ratio, Dilatation dilatation) {
  const ElasticTissue tissue{0.1, ratio};
  const double length_mm = 200.0;
  const double height_mm = 20.0;
  const PlaneGrid grid{static_cast<int>(length_mm / spacing_mm) + 1,
                       static_cast<int>(height_mm / spacing_mm) + 1, spacing_mm};
  VectorXd force = VectorXd::Zero(2 * grid.num_nodes());
  for (int r = 0; r < grid.rows; ++r) {
    // A parabola of shear on the free end, as in a beam; 0.001 N per mm of thickness in all.
    const double y = 2.0 * r / (grid.rows - 1) - 1.0;
    force[2 * grid.Node(grid.columns - 1, r) + 1] = 1.0 - y * y;
  }
  force *= 0.001 / force.sum();
  const VectorXd u = Deform(
      grid, tissue, dilatation, [](const Vector2d& p) { return p.x() == 0.0; }, force);
  const double plane_modulus = tissue.youngs_modulus_mpa / (1 - ratio * ratio);
  const double inertia = std::pow(height_mm, 3) / 12.0;
  const double want_mm = 0.001 * std::pow(length_mm, 3) / (3 * plane_modulus * inertia) +
                         1.2 * 0.001 * length_mm / (tissue.ShearModulusMpa() * height_mm);
  return u[2 * grid.Node(grid.columns - 1, grid.rows / 2) + 1] / want_mm;
}

TEST(PlaneStrainPhysics, CantileverBendsAsABeam) {
  for (const double ratio : {0.3, 0.499, 0.4999}) {
    const double cell = CantileverOverBeam(1.25, ratio, Dilatation::kCell);
    const double triangle = CantileverOverBeam(1.25, ratio, Dilatation::kTriangle);
    std::printf("nu %.4f: cell %.4f, triangle %.4f of the beam's deflection\n", ratio, cell,
                triangle);
    EXPECT_NEAR(cell, 1.0, 0.03) << ratio;
    EXPECT_LT(triangle, cell) << ratio;
  }
}

// Flamant: a line load P on a half plane moves its surface by 2 (1 - nu^2) P / (pi E) ln(d / x).
TEST(PlaneStrainPhysics, LineLoadOnAHalfPlaneIsFlamants) {
  for (const double ratio : {0.3, 0.49}) {
    const ElasticTissue tissue{0.02, ratio};
    const PlaneGrid grid{161, 101, 2.0};  // 320 x 200 mm, loaded in the middle of y = 0
    const int middle = 80;
    VectorXd force = VectorXd::Zero(2 * grid.num_nodes());
    force[2 * grid.Node(middle, 0) + 1] = 0.01;
    const VectorXd u = Deform(
        grid, tissue, Dilatation::kCell,
        [](const Vector2d& p) { return p.y() == 200.0 || p.x() == 0.0 || p.x() == 320.0; }, force);
    const double factor = 2 * (1 - ratio * ratio) * 0.01 / (std::numbers::pi * 0.02);
    const double found_mm =
        u[2 * grid.Node(middle + 3, 0) + 1] - u[2 * grid.Node(middle + 12, 0) + 1];
    const double share = found_mm / (factor * std::log(24.0 / 6.0));
    std::printf("nu %.2f: %.4f of Flamant's displacement\n", ratio, share);
    EXPECT_NEAR(share, 1.0, 0.03) << ratio;
  }
}

/// Mean displacement under a strip load on a block held at its sides and bottom, 40 x 40 mm.
double StripIndentation(double spacing_mm, double ratio, Dilatation dilatation) {
  const int cells = static_cast<int>(std::lround(40.0 / spacing_mm));
  const PlaneGrid grid{cells + 1, cells + 1, spacing_mm};
  VectorXd force = VectorXd::Zero(2 * grid.num_nodes());
  for (int c = 0; c < grid.columns; ++c) {
    const double x = grid.PositionMm(c).x();
    const double edge = std::abs(std::abs(x - 20.0) - 5.0) < 1e-9 ? 0.5 : 1.0;
    if (std::abs(x - 20.0) <= 5.0 + 1e-9) force[2 * grid.Node(c, 0) + 1] = edge;
  }
  force *= 0.05 / force.sum();
  const VectorXd u = Deform(
      grid, {0.02, ratio}, dilatation,
      [](const Vector2d& p) { return p.y() == 40.0 || p.x() == 0.0 || p.x() == 40.0; }, force);
  return force.dot(u) / 0.05;
}

TEST(PlaneStrainPhysics, MeanDilatationDoesNotLock) {
  for (const double ratio : {0.45, 0.49, 0.499, 0.4999}) {
    const double fine_mm = StripIndentation(0.3125, ratio, Dilatation::kCell);
    const double coarse_mm = StripIndentation(1.25, ratio, Dilatation::kCell);
    const double locked_mm = StripIndentation(1.25, ratio, Dilatation::kTriangle);
    EXPECT_NEAR(coarse_mm / fine_mm, 1.0, 0.05) << ratio;
    std::printf("nu %.4f: cell %.4f, triangle %.4f of the fine grid's displacement\n", ratio,
                coarse_mm / fine_mm, locked_mm / fine_mm);
    EXPECT_LT(locked_mm, coarse_mm);
  }
}

TEST(PlaneStrainPhysics, DisplacementsConvergeUnderRefinement) {
  const double finest_mm = StripIndentation(0.3125, 0.49, Dilatation::kCell);
  double before = 1.0;
  for (const double spacing_mm : {5.0, 2.5, 1.25, 0.625}) {
    const double error =
        std::abs(StripIndentation(spacing_mm, 0.49, Dilatation::kCell) / finest_mm - 1.0);
    std::printf("spacing %.4f mm: %.4f off the finest\n", spacing_mm, error);
    EXPECT_LT(error, 0.75 * before) << spacing_mm;
    before = error;
  }
  EXPECT_LT(before, 0.01);
}

}  // namespace
}  // namespace acus::mechanics
