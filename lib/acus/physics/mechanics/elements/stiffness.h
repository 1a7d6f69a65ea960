// The stiffness matrix of a tetrahedral mesh.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <span>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"

namespace acus::mechanics {

/// What is assumed inside a tetrahedron; docs/models/tissue_elasticity.md has errors and costs.
enum class ElementKind {
  /// Constant strain (CalculiX: C3D4). Far too stiff near a Poisson's ratio of 0.5.
  kLinear,
  /// The same, except for the change of volume, which is averaged over patches of one tissue
  /// (mechanics/dilatation_patches.h): right up to 0.4999. After de Souza Neto et al. 2005, small
  /// strains.
  kAveragedDilatation,
};

/// Stiffness of the whole mesh in N/mm: 3n x 3n over all nodes, rows 3 node + axis (LPS),
/// symmetric, *lower triangle only*: multiply with `.selfadjointView<Eigen::Lower>()`. Fixed nodes
/// are in it as if they were free; so that any set of them can be taken out: see FreeStiffness.
/// @param is_left_out  Flag per tetrahedron that resists nothing; empty: none.
/// @throws InputError if a tetrahedron that can be deformed has no positive volume (with its
///     place), or a tissue that the table has no row for. Tetrahedra of four fixed nodes are
///     skipped, and need no row.
Eigen::SparseMatrix<double> AssembleStiffness(const mesh::TetraMesh& mesh,
                                              const ElasticityTable& table, ElementKind kind,
                                              std::span<const std::uint8_t> is_left_out = {});

/// Rows and columns of the free nodes, lower triangle, numbered as FreeNodes says.
/// @param lower_n_per_mm  What AssembleStiffness gave.
Eigen::SparseMatrix<double> FreeStiffness(const Eigen::SparseMatrix<double>& lower_n_per_mm,
                                          const FreeNodes& free);

}  // namespace acus::mechanics
