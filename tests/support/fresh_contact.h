// Contact solved anew and densely, to hold tissue::ContactSystem against.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/physics/tissue/contact_system.h"

namespace acus::testing_support {

/// How far forces are from a dense solve of the same equations.
struct FreshComparison {
  double force_error_n = 0.0;    ///< Largest difference of a force.
  double largest_force_n = 0.0;  ///< Of the dense solve.
  /// Largest breach, by the dense solve, of the conditions that make the sets of sticking and
  /// slipping unknowns the only right ones: forces beyond bounds, N, and displacements on the wrong
  /// side, mm.
  double breach = 0.0;
};

/// Solves all unknowns that are not at a bound in one dense system [A_ll A_ls; A_sl A_ss], built
/// from `compliance` (which may be another one than the state was stepped with).
inline FreshComparison CompareWithFresh(const tissue::ContactSystem& system,
                                        const tissue::ContactState& state) {
  using tissue::ContactStatus;
  struct Unknown {
    tissue::ContactPlace place;
    Eigen::Vector3d direction;
    double local = 0.0;
    double demand = 0.0;
    double found = 0.0;
    int column = -1;  ///< Of the bounded ones.
    bool given = false;
  };
  std::vector<Unknown> all;
  for (int p = 0; p < state.num_points(); ++p) {
    for (int d = 0; d < 2; ++d) {
      all.push_back({state.point_place(p), state.frame().col(d),
                     state.point_local(p).lateral_mm_per_n, state.LateralMm(2 * p + d),
                     state.PointForceN(p)[d], -1, false});
    }
  }
  for (int s = 0; s < state.num_slots(); ++s) {
    if (!state.slot_in_use(s)) continue;
    all.push_back({state.slot_place(s), state.slot_direction(s), state.slot_local_mm_per_n(s),
                   state.DemandMm(s), state.SlotForceN(s), s,
                   state.Status(s) != ContactStatus::kStick});
  }
  for (int p = 0; p < state.num_points(); ++p) {
    const int column = state.num_slots() + p;
    all.push_back({state.point_place(p), state.frame().col(2), state.point_local(p).axial_mm_per_n,
                   state.DemandMm(column), state.PointForceN(p)[2], column,
                   state.Status(column) != ContactStatus::kStick});
  }
  const Eigen::Index size = static_cast<Eigen::Index>(all.size());
  Eigen::MatrixXd compliance(size, size);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(size);
  std::vector<int> solved;
  for (Eigen::Index i = 0; i < size; ++i) {
    const Unknown& a = all[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Unknown& b = all[static_cast<std::size_t>(j)];
      compliance(i, j) = a.direction.dot(system.Between(a.place, b.place) * b.direction);
      compliance(j, i) = compliance(i, j);
    }
    compliance(i, i) += a.local;
    if (a.given) {
      force[i] = state.Status(a.column) == ContactStatus::kAtLow ? state.LowN(a.column)
                                                                 : state.HighN(a.column);
    } else {
      solved.push_back(static_cast<int>(i));
    }
  }
  Eigen::VectorXd demand(size);
  for (Eigen::Index i = 0; i < size; ++i) demand[i] = all[static_cast<std::size_t>(i)].demand;
  const Eigen::VectorXd left = demand - compliance * force;
  const Eigen::MatrixXd part = compliance(solved, solved);
  const Eigen::VectorXd some = part.ldlt().solve(Eigen::VectorXd(left(solved)));
  force(solved) = some;
  const Eigen::VectorXd moved = compliance * force;

  FreshComparison out;
  for (Eigen::Index i = 0; i < size; ++i) {
    const Unknown& unknown = all[static_cast<std::size_t>(i)];
    out.force_error_n = std::max(out.force_error_n, std::abs(force[i] - unknown.found));
    out.largest_force_n = std::max(out.largest_force_n, std::abs(force[i]));
    if (unknown.column < 0) continue;
    const double low = state.LowN(unknown.column);
    const double high = state.HighN(unknown.column);
    const double excess = moved[i] - unknown.demand;
    switch (state.Status(unknown.column)) {
      case ContactStatus::kOff:
        break;
      case ContactStatus::kStick:
        out.breach = std::max({out.breach, low - force[i], force[i] - high});
        break;
      case ContactStatus::kAtLow:
        if (low < high) out.breach = std::max(out.breach, -excess);
        break;
      case ContactStatus::kAtHigh:
        if (low < high) out.breach = std::max(out.breach, excess);
        break;
    }
  }
  return out;
}

}  // namespace acus::testing_support
