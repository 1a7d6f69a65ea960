// Linear elasticity in one plane: triangles on a regular grid, plane strain, explicit inverse. The
// tissue of the simulator of 2010 (Augmented-2010, section II.B, after DiMaio and Salcudean).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "acus/physics/mechanics/elements/elasticity_table.h"

namespace acus::mechanics {

/// Nodes at (column, row) * spacing. Every cell is cut into two triangles, the diagonals alternate,
/// so that no direction is preferred.
struct PlaneGrid {
  int columns = 2;  ///< Nodes along x, >= 2.
  int rows = 2;     ///< Nodes along y, >= 2.
  double spacing_mm = 1.0;

  int num_nodes() const { return columns * rows; }
  int num_cells() const { return (columns - 1) * (rows - 1); }
  int num_triangles() const { return 2 * num_cells(); }
  int Node(int column, int row) const { return row * columns + column; }
  Eigen::Vector2d PositionMm(int node) const {
    return spacing_mm * Eigen::Vector2d(node % columns, node / columns);
  }
  /// Nodes of triangle 2 cell + half, anticlockwise in (x, y); cells go row by row.
  std::array<int, 3> Triangle(int triangle) const;
  Eigen::Vector2d CentroidMm(int triangle) const;

  /// Linear interpolation: three nodes and their weights at a point.
  struct Place {
    std::array<int, 3> node{};
    std::array<double, 3> weight{};
    int triangle = -1;  ///< -1: outside the grid.
  };
  Place PlaceOf(const Eigen::Vector2d& point_mm) const noexcept;
};

/// What the volume change of a triangle is: its own, or the mean of the two triangles of its cell
/// (where both are the same tissue), which leaves one volume constraint for two unknowns. Triangles
/// with their own lock as Poisson's ratio nears 0.5; alternating diagonals already remove most of
/// it.
enum class Dilatation { kTriangle, kCell };

/// A triangle with this modulus is empty: there is no tissue.
inline constexpr double kEmptyMpa = 0.0;

/// Triangles that nothing holds are emptied: parts, joined by edges, with fewer than two fixed
/// nodes could move freely. @return how many.
int EmptyUnsupported(const PlaneGrid& grid, const std::vector<char>& fixed,
                     std::vector<ElasticTissue>& tissue);

/// Stiffness per mm of thickness, N/mm per mm, of all 2 num_nodes() degrees of freedom (2 node +
/// axis).
/// @param tissue  per triangle.
/// @throws InputError for a modulus below 0 or a Poisson's ratio outside (-1, 0.5).
Eigen::SparseMatrix<double> PlaneStiffness(const PlaneGrid& grid,
                                           const std::vector<ElasticTissue>& tissue,
                                           Dilatation dilatation);

/// The explicit inverse of the stiffness of all free nodes.
struct PlaneCompliance {
  std::vector<int> dof_of_node;  ///< First of two rows; -1: fixed, or without tissue.
  Eigen::MatrixXd matrix;        ///< mm per (N per mm of thickness); symmetric.

  int num_dofs() const { return static_cast<int>(matrix.rows()); }
};

/// Cost O(num_dofs^3); 2000 nodes take about a second.
/// @param fixed  per node, nonzero: does not move.
/// @throws InputError if nothing is free, or if a part can move without resistance.
PlaneCompliance InvertPlane(const PlaneGrid& grid, const std::vector<ElasticTissue>& tissue,
                            const std::vector<char>& fixed, Dilatation dilatation);

}  // namespace acus::mechanics
