// A tetrahedron in which displacements are linear. Private to this module.
#pragma once

#include <Eigen/Dense>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"

namespace acus::mechanics {

struct LinearTetrahedron {
  double volume_mm3 = 0.0;
  Eigen::Matrix<double, 3, 4> gradients_per_mm;  ///< Of the four shape functions.
};

/// @throws InputError naming the tetrahedron's place if its volume is not positive, or so small
/// beside its edges that its gradients are noise (1e-12 of the cube of the longest edge).
LinearTetrahedron LinearTetrahedronOf(const mesh::TetraMesh& mesh, int tetrahedron);

/// Displacement of four corners (12, corner by corner) -> forces on them, N/mm.
using TetrahedronMatrix = Eigen::Matrix<double, 12, 12>;

/// Stiffness against change of shape: volume * 2 G dev(strain) : dev(strain).
TetrahedronMatrix DeviatoricStiffness(const LinearTetrahedron& element, double shear_modulus_mpa);

/// Change of volume by displacement of the corners, mm^2: row b with dV = b u.
Eigen::Matrix<double, 12, 1> VolumeGradientMm2(const LinearTetrahedron& element);

}  // namespace acus::mechanics
