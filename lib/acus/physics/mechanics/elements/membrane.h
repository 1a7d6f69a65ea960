// Membranes: thin, stiff, stretched layers on the surfaces of tissues, such as the dermis on the
// subcutis, fascia on muscle, the capsule of an organ. A mesh for tissue cannot resolve them: they
// are shells on its faces.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/labels.h"

namespace acus::mechanics {

/// An isotropic shell in tension on the surface of one tissue.
struct Membrane {
  volume::Label tissue = 0;  ///< That it covers.
  std::bitset<256> against;  ///< Tissues on its other side; 0: outside the body.
  double youngs_modulus_mpa = 0.0;
  double poissons_ratio = 0.0;
  double thickness_mm = 0.0;
  double tension_n_per_mm = 0.0;  ///< At rest, the same in all directions of the surface.

  /// E t^3 / 12 (1 - nu^2), N mm.
  double BendingStiffnessNmm() const;
  /// E t / (1 - nu^2), N/mm.
  double StretchingStiffnessNPerMm() const;
};

/// A face of a membrane, with the corners opposite of its edges in the three faces beside it.
struct MembraneFace {
  std::array<int, 3> corner{};  ///< Mesh nodes, seen from outside the tissue.
  /// Beyond the edge opposite of corner n; -1: none, a rim or a fold.
  std::array<int, 3> opposite{-1, -1, -1};
};

/// The faces of the mesh on which the membrane lies, in the order of the tetrahedra.
/// @param is_left_out  Flag per tetrahedron that resists nothing; empty: none.
std::vector<MembraneFace> FacesOf(const Membrane& membrane, const mesh::TetraMesh& mesh,
                                  std::span<const std::uint8_t> is_left_out = {});

/// Stiffness of membranes in N/mm: 3n x 3n over all nodes, lower triangle, as AssembleStiffness
/// numbers. Per face: plane stress with constant strain; tension T |grad w|^2 / 2 with the
/// displacement w along its normal; bending D ((w_xx + w_yy)^2 - 2 (1 - nu) (w_xx w_yy - w_xy^2)) /
/// 2 with constant curvature, from the three corners and the three opposite ones (a patch without
/// rotations, after Phaal and Calladine 1992, Int. J. Numer. Meth. Eng. 35:955-977). Rigid motions
/// need no force except for tension, which resists turning. docs/models/tissue_membranes.md
Eigen::SparseMatrix<double> MembraneStiffness(const mesh::TetraMesh& mesh,
                                              std::span<const Membrane> membranes,
                                              std::span<const std::uint8_t> is_left_out = {});

/// Displacement along its normal of a plane membrane on an elastic half space, mm per N, of the
/// load itself: Hankel transform of 1 / (D k^4 + T k^2 + G k / (1 - nu)). Load and mean are taken
/// with the weight (1 - r^2/R^2)^2 within R = radius_mm; 0: of a point (finite if the membrane has
/// thickness).
/// @param shear_mpa, poissons_ratio  Of the half space; bonded, exact at a ratio of 0.5.
double MembraneComplianceMmPerN(const Membrane& membrane, double shear_mpa, double poissons_ratio,
                                double radius_mm);

}  // namespace acus::mechanics
