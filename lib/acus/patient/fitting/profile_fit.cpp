#include "acus/patient/fitting/profile_fit.h"

#include <Eigen/Dense>
#include <algorithm>

namespace acus::fitting {

Eigen::MatrixXd ProfileColumns(const StrainedRows& rows, const std::vector<double>& knots) {
  const auto n = static_cast<Eigen::Index>(rows.depth_mm.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(knots.size()));
  for (Eigen::Index i = 0; i < n; ++i) {
    const double depth = rows.depth_mm[static_cast<std::size_t>(i)];
    const auto above = std::upper_bound(knots.begin(), knots.end(), depth);
    const auto k = std::clamp<std::ptrdiff_t>(above - knots.begin(), 1,
                                              static_cast<std::ptrdiff_t>(knots.size()) - 1);
    const auto u = static_cast<std::size_t>(k);
    const double along = (depth - knots[u - 1]) / (knots[u] - knots[u - 1]);
    columns(i, k - 1) = (1.0 - along) * rows.strain[static_cast<std::size_t>(i)];
    columns(i, k) = along * rows.strain[static_cast<std::size_t>(i)];
  }
  return columns;
}

std::vector<double> SolveProfile(Eigen::MatrixXd normal, const Eigen::VectorXd& right) {
  const Eigen::Index n = normal.rows();
  const double weight = 1e-6 * normal.trace() / static_cast<double>(n);
  const Eigen::Vector3d bend(1.0, -2.0, 1.0);
  for (Eigen::Index k = 0; k + 2 < n; ++k) {
    normal.block<3, 3>(k, k) += weight * bend * bend.transpose();
  }
  normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
  const Eigen::VectorXd solution = normal.ldlt().solve(right);
  return {solution.begin(), solution.end()};
}

void FitProfile(const StrainedRows& rows, std::span<const double> event_force_n,
                ResistanceProfile& profile) {
  profile.force_n.assign(profile.depth_mm.size(), 0.0);
  if (rows.depth_mm.empty()) return;
  const Eigen::MatrixXd columns = ProfileColumns(rows, profile.depth_mm);
  Eigen::VectorXd force = Eigen::Map<const Eigen::VectorXd>(
      rows.force_n.data(), static_cast<Eigen::Index>(rows.force_n.size()));
  for (Eigen::Index i = 0; i < force.size() && !event_force_n.empty(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    force(i) -= rows.strain[k] * event_force_n[k];
  }
  profile.force_n = SolveProfile(columns.transpose() * columns, columns.transpose() * force);
}

}  // namespace acus::fitting
