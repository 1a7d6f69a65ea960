// Non-negative least squares.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace acus::fitting {

struct NonNegativeSolution {
  Eigen::VectorXd x;          ///< >= 0.
  std::vector<bool> is_free;  ///< By unknown: not held at 0.
};

/// Minimises x^T normal x / 2 - right^T x over x >= 0: Lawson & Hanson 1974, chapter 23, on the
/// normal equations. Exact up to rounding: where x is free its gradient is 0, where it is held at 0
/// the objective would rise with it.
/// @pre `normal` is symmetric and positive definite.
NonNegativeSolution SolveNonNegative(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right);

}  // namespace acus::fitting
