// A linear tetrahedron that is turned as a whole: strain is measured in its own frame.
#pragma once

#include <Eigen/Dense>

#include "acus/physics/mechanics/elements/linear_tetrahedron.h"
#include "references/mesh_newton.h"

namespace acus::mechanics {

using CornerVectors = Eigen::Matrix<double, 3, 4>;  ///< One column per corner.

/// The state of one tetrahedron: deformation gradient F = R S, R a proper rotation, also where the
/// tetrahedron is inside out (then one stretch is negative; Irving et al. 2004).
struct RotatedTetrahedron {
  Eigen::Matrix3d gradient;     ///< F.
  Eigen::Matrix3d rotation;     ///< R.
  Eigen::Vector3d stretches;    ///< Signed singular values of F, descending.
  Eigen::Matrix3d left, right;  ///< F = left diag(stretches) right^T, both proper rotations.

  /// Trace of S - 1: the change of volume to first order.
  double Dilatation() const { return stretches.sum() - 3.0; }
};

RotatedTetrahedron Rotated(const LinearTetrahedron& element, const CornerVectors& displacement_mm);

/// Energy of the change of shape, G V |dev(S - 1)|^2, in N mm, and of what keeps a single
/// tetrahedron from collapsing at large strains.
double ShapeEnergyNmm(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                      double shear_modulus_mpa);

/// Forces that hold the corners, N: of the change of shape, and of a mean stress.
CornerVectors CornerForcesN(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                            double shear_modulus_mpa, double mean_stress_mpa);

/// Change of the mean dilatation times the volume by displacements of the corners, mm^2.
CornerVectors RotatedVolumeGradientMm2(const LinearTetrahedron& element,
                                       const RotatedTetrahedron& state);

/// Second derivative of the energy at constant mean dilatation (Smith, de Goes and Kim 2019, their
/// "ARAP" energy): exact, or with what is negative of it left out, so that steps go down.
TetrahedronMatrix CornerStiffness(const LinearTetrahedron& element, const RotatedTetrahedron& state,
                                  double shear_modulus_mpa, double mean_stress_mpa,
                                  Curvature curvature);

}  // namespace acus::mechanics
