// Displacements approach the exact ones with the square of the element size.
#include <gtest/gtest.h>

#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

/// u_i = a_i sin(k_i . x + p_i), and the force per volume that holds it: -div stress.
struct Waves {
  Eigen::Matrix3d wave;  ///< Rows: k_i, 1/mm.
  Eigen::Vector3d height_mm;
  Eigen::Vector3d phase;

  Eigen::Vector3d At(const Eigen::Vector3d& x) const {
    return (height_mm.array() * (wave * x + phase).array().sin()).matrix();
  }
  /// G laplace(u) + (K + G / 3) grad div(u), negative.
  Eigen::Vector3d ForceDensity(const Eigen::Vector3d& x, const ElasticTissue& tissue) const {
    const double g = tissue.ShearModulusMpa();
    const double second = tissue.BulkModulusMpa() + g / 3.0;
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const double s = height_mm[i] * std::sin(wave.row(i).dot(x) + phase[i]);
      f[i] += g * wave.row(i).squaredNorm() * s;
      f += second * wave(i, i) * s * wave.row(i).transpose();
    }
    return f;
  }
};

/// Any waves, and waves in each of which no component depends on its own axis: no change of volume.
Waves Compressing() {
  Eigen::Matrix3d k;
  k << 2.0, 1.0, -0.5, 1.0, -1.5, 1.0, 0.5, 1.0, 2.0;
  return {k, {1.0, -0.7, 0.8}, {0.3, 0.1, -0.2}};
}
Waves Sheared() {
  Eigen::Matrix3d k;
  k << 0.0, 2.0, -1.0, 1.5, 0.0, 2.0, 2.0, -1.5, 0.0;
  return {k, {1.0, -0.7, 0.8}, {0.3, 0.1, -0.2}};
}

double ErrorWith(int cells, ElementKind kind, const ElasticTissue& tissue, const Waves& waves) {
  mesh::TetraMesh box = BoxMesh({cells, cells, cells}, {0, 0, 0}, {1, 1, 1}, 0.15, 5);
  FixSurface(box);
  const auto exact = [&](const Eigen::Vector3d& x) { return waves.At(x); };
  const Eigen::Matrix3Xd load =
      BodyLoad(box, [&](const Eigen::Vector3d& x) { return waves.ForceDensity(x, tissue); });
  const StaticSolver solver(box, UniformTable(tissue.youngs_modulus_mpa, tissue.poissons_ratio),
                            kind);
  return RelativeL2Error(box, solver.Displacements(load, AtNodes(box, exact)), exact);
}

/// Slope of the logarithms, from the two finest of three meshes.
double Order(ElementKind kind, const ElasticTissue& tissue, const Waves& waves) {
  const double coarse = ErrorWith(9, kind, tissue, waves);
  const double fine = ErrorWith(18, kind, tissue, waves);
  EXPECT_LT(fine, 0.01);
  return std::log2(coarse / fine);
}

TEST(MechanicsConvergence, LinearElementsAreOfSecondOrder) {
  EXPECT_GE(Order(ElementKind::kLinear, {0.01, 0.3}, Compressing()), 1.9);
}

TEST(MechanicsConvergence, AveragedDilatationIsOfSecondOrder) {
  EXPECT_GE(Order(ElementKind::kAveragedDilatation, {0.01, 0.3}, Compressing()), 1.9);
}

TEST(MechanicsConvergence, AveragedDilatationIsOfSecondOrderWhenNearlyIncompressible) {
  for (const double nu : {0.49, 0.499, 0.4999}) {
    EXPECT_GE(Order(ElementKind::kAveragedDilatation, {0.01, nu}, Sheared()), 1.9) << nu;
  }
}

}  // namespace
}  // namespace acus::mechanics
