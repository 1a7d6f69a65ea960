// A Cholesky factor that ends with chosen nodes: the inverse of its last block is their compliance.
// Private to this module.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <span>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::mechanics {

/// A view of the factor L of K = L L^T, columns in groups ("supernodes") that share their rows.
/// Group s has columns first_column[s] .. first_column[s + 1] and rows
/// rows[first_row[s] .. first_row[s + 1]], the first of which are its columns; its values begin at
/// values[first_value[s]], column by column. Rows are numbered in the order of elimination.
struct Supernodes {
  int count = 0;
  const long* first_column = nullptr;
  const long* first_row = nullptr;
  const long* first_value = nullptr;
  const long* rows = nullptr;
  const double* values = nullptr;
};

/// K is factored once, in an order that ends with the rows R of the chosen nodes:
///     K = L L^T,  L = [L11 0; L21 L22],  (K^-1)_RR = L22^-T L22^-1.
class CondensedFactor {
 public:
  /// @param lower_n_per_mm  Stiffness of the free nodes (3 rows each), lower triangle, compressed.
  ///     Is emptied: the factor needs the memory.
  /// @param last  Rows of free nodes to condense to, ascending, each once, at least one.
  /// @param max_memory_mib  What the factor may take.
  /// @throws NoAnswerError if it would take more, or the matrix is not positive definite.
  CondensedFactor(Eigen::SparseMatrix<double>&& lower_n_per_mm, std::span<const int> last,
                  double max_memory_mib, const RunContext& context);
  ~CondensedFactor();
  CondensedFactor(CondensedFactor&&) noexcept;
  CondensedFactor& operator=(CondensedFactor&&) noexcept;

  using View = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  /// 3 n x 3 n for the n nodes of `last`, symmetric, mm/N. It lies where L22 was.
  View ComplianceMmPerN() const;

  Supernodes supernodes() const;
  /// Row of the stiffness matrix for each row in the order of elimination.
  std::span<const long> order() const;
  double num_values() const;  ///< Stored in the factor.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace acus::mechanics
