#include "acus/patient/fitting/non_negative.h"

#include <Eigen/Dense>

#include "acus/base/core/error.h"

namespace acus::fitting {
namespace {

constexpr double kRounding = 1e-12;

std::vector<Eigen::Index> Free(const std::vector<bool>& is_free) {
  std::vector<Eigen::Index> free;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (is_free[k]) free.push_back(static_cast<Eigen::Index>(k));
  }
  return free;
}

/// Without bounds, with the unknowns that are not free at 0.
Eigen::VectorXd SolveFree(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right,
                          const std::vector<Eigen::Index>& free) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
  const Eigen::VectorXd part = right(free);
  x(free) = normal(free, free).ldlt().solve(part).eval();
  return x;
}

/// From x >= 0 to the free minimum; where that is negative, only up to the first bound, which is
/// then held.
void MoveToFreeMinimum(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right,
                       NonNegativeSolution& solution) {
  for (;;) {
    const std::vector<Eigen::Index> free = Free(solution.is_free);
    const Eigen::VectorXd goal = SolveFree(normal, right, free);
    double share = 1.0;
    Eigen::Index first = -1;
    for (const Eigen::Index k : free) {
      if (goal(k) > 0.0) continue;
      const double at = solution.x(k) > 0.0 ? solution.x(k) / (solution.x(k) - goal(k)) : 0.0;
      if (first >= 0 && at >= share) continue;
      share = at;
      first = k;
    }
    solution.x += share * (goal - solution.x);
    if (first < 0) return;
    solution.x(first) = 0.0;
    solution.is_free[static_cast<std::size_t>(first)] = false;
  }
}

}  // namespace

NonNegativeSolution SolveNonNegative(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) {
  ACUS_ASSERT(normal.rows() == normal.cols() && normal.rows() == right.size());
  NonNegativeSolution solution{
      .x = Eigen::VectorXd::Zero(right.size()),
      .is_free = std::vector(static_cast<std::size_t>(right.size()), false)};
  const double least = kRounding * right.cwiseAbs().maxCoeff();
  // Each round lowers the objective, so no set of free unknowns comes twice; the limit is for
  // rounding.
  for (Eigen::Index round = 0; round < 10 * right.size(); ++round) {
    const Eigen::VectorXd fall = right - normal * solution.x;
    Eigen::Index steepest = -1;
    for (Eigen::Index k = 0; k < fall.size(); ++k) {
      if (solution.is_free[static_cast<std::size_t>(k)] || fall(k) <= least) continue;
      if (steepest < 0 || fall(k) > fall(steepest)) steepest = k;
    }
    if (steepest < 0) break;
    solution.is_free[static_cast<std::size_t>(steepest)] = true;
    MoveToFreeMinimum(normal, right, solution);
  }
  return solution;
}

}  // namespace acus::fitting
