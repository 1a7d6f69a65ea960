#include "references/corotational_element.h"

#include <algorithm>
#include <cmath>

namespace acus::mechanics {
namespace {

// Averaged dilatation leaves single tetrahedra soft against a change of volume of their own. That
// does no harm near rest, but at strains of 30 % some would collapse one by one. This term keeps
// them: G V kOwnDilatation tr^4, which is nothing near rest.
constexpr double kOwnDilatation = 10.0;

/// Stress along the rotation: of the mean stress, of the tetrahedron's own dilatation, and what the
/// trace takes from the shape's part.
double StressAlongRotation(const RotatedTetrahedron& state, double shear_modulus_mpa,
                           double mean_stress_mpa) {
  const double own = state.Dilatation();
  return mean_stress_mpa + shear_modulus_mpa * own * (4.0 * kOwnDilatation * own * own - 2.0 / 3.0);
}

}  // namespace

RotatedTetrahedron Rotated(const LinearTetrahedron& element, const CornerVectors& displacement_mm) {
  RotatedTetrahedron state;
  state.gradient =
      Eigen::Matrix3d::Identity() + displacement_mm * element.gradients_per_mm.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(state.gradient,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  state.left = svd.matrixU();
  state.right = svd.matrixV();
  state.stretches = svd.singularValues();
  // The smallest stretch carries the sign, so that a point that turns inside out passes smoothly.
  for (Eigen::Matrix3d* side : {&state.left, &state.right}) {
    if (side->determinant() > 0.0) continue;
    side->col(2) = -side->col(2);
    state.stretches[2] = -state.stretches[2];
  }
  state.rotation = state.left * state.right.transpose();
  return state;
}

double ShapeEnergyNmm(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                      double shear_modulus_mpa) {
  const double trace = state.Dilatation();
  return element.volume_mm3 * shear_modulus_mpa *
         ((state.stretches.array() - 1.0).matrix().squaredNorm() - trace * trace / 3.0 +
          kOwnDilatation * trace * trace * trace * trace);
}

CornerVectors CornerForcesN(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                            double shear_modulus_mpa, double mean_stress_mpa) {
  // The derivative of R drops out of that of |F - R|^2 and of trace(R^T F).
  const Eigen::Matrix3d stress =
      2.0 * shear_modulus_mpa * (state.gradient - state.rotation) +
      StressAlongRotation(state, shear_modulus_mpa, mean_stress_mpa) * state.rotation;
  return element.volume_mm3 * stress * element.gradients_per_mm;
}

CornerVectors RotatedVolumeGradientMm2(const LinearTetrahedron& element,
                                       const RotatedTetrahedron& state) {
  return element.volume_mm3 * state.rotation * element.gradients_per_mm;
}

TetrahedronMatrix CornerStiffness(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                                  double shear_modulus_mpa, double mean_stress_mpa,
                                  Curvature curvature) {
  using Corners = Eigen::Matrix<double, 12, 1>;
  const CornerVectors& g = element.gradients_per_mm;
  const double twice_shear = 2.0 * shear_modulus_mpa;
  TetrahedronMatrix k;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      k.block<3, 3>(3 * i, 3 * j) =
          twice_shear * g.col(i).dot(g.col(j)) * Eigen::Matrix3d::Identity();
    }
  }
  const CornerVectors along = state.rotation * g;
  const Eigen::Map<const Corners> a(along.data());
  const double own = state.Dilatation();
  k += twice_shear * (6.0 * kOwnDilatation * own * own - 1.0 / 3.0) * a * a.transpose();
  // Turning about each axis of stretch: the stiffness is that of the stress held there.
  const double stress = StressAlongRotation(state, shear_modulus_mpa, mean_stress_mpa);
  for (int axis = 0; axis < 3; ++axis) {
    const int p = (axis + 1) % 3;
    const int q = (axis + 2) % 3;
    const Eigen::Matrix3d turn = (state.left.col(p) * state.right.col(q).transpose() -
                                  state.left.col(q) * state.right.col(p).transpose()) /
                                 std::sqrt(2.0);
    const double weight = 2.0 / std::max(state.stretches[p] + state.stretches[q], 0.1);
    double turning = twice_shear + (stress - twice_shear) * weight;
    if (curvature == Curvature::kPositive) turning = std::max(0.0, turning);
    const CornerVectors turned = turn * g;
    const Eigen::Map<const Corners> t(turned.data());
    k += (turning - twice_shear) * t * t.transpose();
  }
  return element.volume_mm3 * k;
}

}  // namespace acus::mechanics
