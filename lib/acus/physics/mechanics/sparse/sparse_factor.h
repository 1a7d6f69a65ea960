// Solves equations with a sparse symmetric positive definite matrix, such as a stiffness.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace acus::mechanics {

/// A Cholesky factor, by CHOLMOD (supernodal, METIS order, one thread): the same matrix gives the
/// same bits. Not to be used by two threads at once.
class SparseFactor {
 public:
  /// @param lower  Lower triangle, compressed. What is above the diagonal is not read.
  /// @param block  Rows that belong together, such as 3 per node: ordering goes by blocks.
  /// @throws NoAnswerError if the matrix is not positive definite, or memory runs out.
  /// @pre the number of rows is a multiple of `block`.
  explicit SparseFactor(const Eigen::SparseMatrix<double>& lower, int block = 3);
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  /// Solutions of all columns at once. @pre as many rows as the matrix has.
  Eigen::MatrixXd Solve(const Eigen::Ref<const Eigen::MatrixXd>& right_sides) const;

  /// The same matrix with other values in the same places: keeps the order.
  void Refactor(const Eigen::SparseMatrix<double>& lower);

  /// The same, but false if the matrix is not positive definite; then only another Refactor helps.
  [[nodiscard]] bool TryRefactor(const Eigen::SparseMatrix<double>& lower);

  int num_rows() const;
  double num_values() const;      ///< Stored in the factor.
  double num_operations() const;  ///< Of the factorisation, floating point.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace acus::mechanics
