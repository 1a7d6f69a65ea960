// A part of a condensed body at large strain: what its linear model lacks, as forces on its nodes.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/mechanics/elements/finite_strain_body.h"

namespace acus::mechanics {

/// Patches of the averaged dilatation (or single tetrahedra, for linear elements) all of whose
/// nodes are in a compliance or fixed. If there are more than `max_nodes` allow, those that trial
/// forces along the needle's corridor strain most, three times as strong on the skin as inside. The
/// rest of the body stays linear. Const after construction.
class StrainRegion {
 public:
  /// @param compliance  Of nodes of `mesh`, condensed with `kind` and the moduli of `table`.
  /// @param line  The needle's corridor, from outside the skin inwards.
  StrainRegion(const mesh::TetraMesh& mesh, const ElasticityTable& table, ElementKind kind,
               const Compliance& compliance, const Capsule& line, int max_nodes);

  /// Rows of the compliance of the nodes, ascending.
  std::span<const int> rows() const { return rows_; }
  int num_nodes() const { return static_cast<int>(rows_.size()); }
  int num_tetrahedra() const { return static_cast<int>(body_.shapes.size()); }
  /// Place of a row of the compliance in rows(), or -1.
  int IndexOf(int row) const noexcept { return index_of_row_[static_cast<std::size_t>(row)]; }

  /// Memory that a caller keeps for MissingForces; one per thread.
  using Scratch = std::vector<StrainedTetrahedron>;
  Scratch NewScratch() const { return Scratch(body_.shapes.size()); }

  /// The forces that the linear model needs beside those of the tools to move as the laws do:
  ///   f_linear(u) - f_law(u), N, 3 x num_nodes().
  /// @param u_mm  3 x (num_nodes() + 1), the last column 0: nodes that are held.
  /// @param out_n  The same shape; its last column is of no use. Allocates nothing.
  void MissingForces(const Eigen::Ref<const Eigen::Matrix3Xd>& u_mm, Scratch& scratch,
                     Eigen::Ref<Eigen::Matrix3Xd> out_n) const noexcept;

  const FiniteStrainBody& body() const { return body_; }

 private:
  FiniteStrainBody body_;
  std::vector<int> rows_;
  std::vector<int> index_of_row_;
};

}  // namespace acus::mechanics
