// Shape of tetrahedra.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

using Corners = std::array<Eigen::Vector3d, 4>;  ///< Positive volume: d above a, b, c seen CCW.

double VolumeMm3(const Corners& corners);  ///< Negative if inside out.

/// The six dihedral angles, in rad, at the edges ab, ac, ad, bc, bd, cd. @pre positive volume.
std::array<double, 6> DihedralAnglesRad(const Corners& corners);

/// Radius of the circumscribed sphere over the shortest edge; regular: sqrt(6)/4 = 0.612.
double RadiusEdgeRatio(const Corners& corners);

/// Minus the cosine of the smallest dihedral angle: rises with that angle, and costs no arc cosine.
/// -2 for a tetrahedron without positive volume. Regular: -1/3.
double DihedralScore(const Corners& corners);

/// The score of a tetrahedron whose smallest dihedral angle is `degrees`.
double ScoreOfDegrees(double degrees);
double DegreesOfScore(double score);

Corners CornersOf(const TetraMesh& mesh, Eigen::Index tetrahedron);

struct QualityReport {
  Eigen::Index num_nodes = 0;
  Eigen::Index num_tetrahedra = 0;
  Eigen::Index num_inverted = 0;  ///< Without positive volume; not counted in what follows.
  double min_dihedral_deg = 0.0;
  double max_dihedral_deg = 0.0;
  double mean_min_dihedral_deg = 0.0;  ///< Mean over tetrahedra of their smallest angle.
  double max_radius_edge_ratio = 0.0;
  Eigen::Index num_fixed_nodes = 0;
  Eigen::Vector3d worst_at_mm =
      Eigen::Vector3d::Zero();               ///< Centre of the one with the least angle.
  std::array<Eigen::Index, 36> histogram{};  ///< Dihedral angles per 5 degrees from 0 to 180.
};

QualityReport MeasureQuality(const TetraMesh& mesh);

}  // namespace acus::mesh
