// Displacements of a mesh under forces, for small strains and small turns.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"
#include "acus/physics/mechanics/sparse/sparse_factor.h"

namespace acus::mechanics {

/// Factors a mesh's stiffness once and solves for any number of loads: the reference for everything
/// that is condensed from the same mesh.
class StaticSolver {
 public:
  /// @throws as FindFreeNodes, AssembleStiffness and SparseFactor.
  StaticSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table, ElementKind kind);

  /// Displacements of all nodes, 3 x n, mm.
  /// @param force_n  3 x n, LPS; forces on held nodes have no effect.
  /// @param held_mm  3 x n: where fixed nodes are moved to; other columns are not read. Empty: they
  ///     stay.
  Eigen::Matrix3Xd Displacements(const Eigen::Matrix3Xd& force_n,
                                 const Eigen::Matrix3Xd& held_mm = {}) const;

  /// Forces on all nodes that hold these displacements, 3 x n, N: at held nodes the reactions.
  Eigen::Matrix3Xd Forces(const Eigen::Matrix3Xd& displacement_mm) const;

  const FreeNodes& free() const { return free_; }
  const SparseFactor& factor() const { return factor_; }

 private:
  FreeNodes free_;
  Eigen::SparseMatrix<double> stiffness_n_per_mm_;  ///< All nodes, lower triangle.
  SparseFactor factor_;
};

}  // namespace acus::mechanics
