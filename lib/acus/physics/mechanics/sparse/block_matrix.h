// Sums small dense matrices of nodes into a sparse symmetric one. Private to this module.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <utility>
#include <vector>

#include "acus/physics/mechanics/elements/element_patches.h"

namespace acus::mechanics {

/// The lower triangle of a symmetric matrix of 3 x 3 blocks, one per pair of nodes that are in a
/// patch together. Made with all its places first, so that adding costs no memory.
class BlockMatrix {
 public:
  /// @param patches  Their nodes are coupled.
  BlockMatrix(int num_nodes, std::span<const ElementPatch> patches);

  /// Adds a symmetric matrix of 3 rows per node; all nodes are in one patch.
  void Add(std::span<const int> nodes, const Eigen::Ref<const Eigen::MatrixXd>& block);

  /// 3 num_nodes rows, lower triangle, compressed. Diagonal blocks of nodes in no group are absent.
  Eigen::SparseMatrix<double> Take() && { return std::move(matrix_); }

 private:
  Eigen::SparseMatrix<double> matrix_;
  std::vector<int> first_;  ///< Of each node's column, into rows_.
  std::vector<int> rows_;   ///< Nodes >= the column's, ascending.
};

}  // namespace acus::mechanics
