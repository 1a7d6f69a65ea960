// A needle bent by tissue and by a hand that is not in line with its channel, and what to compare.
#pragma once

#include <algorithm>
#include <vector>

#include "acus/physics/needle/rod.h"
#include "unit/physics/needle/rods.h"

namespace acus::needle::testing_support {

using Eigen::Vector3d;

inline RodContact TipSpring(const Vector3d& anchor_mm, double stiffness_n_per_mm) {
  RodContact tip;
  tip.arc_mm = kLengthMm;
  tip.anchor_mm = anchor_mm;
  tip.stiffness_n_per_mm = stiffness_n_per_mm;
  return tip;
}

/// A needle whose front half is in tissue, bent by a hand that is not in line with its channel.
struct Inserted {
  std::vector<RodContact> contacts = Channel(75.0, 12, 0.3);
  RodBase base;

  Inserted() {
    contacts.push_back(TipSpring({0.0, 0.0, kLengthMm}, 0.5));
    base.position_mm = {8.0, -3.0, 0.5};
    base.orientation = Eigen::AngleAxisd(0.1, Vector3d::UnitY());
  }
  RodInput input() const {
    RodInput in = Input(contacts);
    in.base = base;
    return in;
  }
};

inline double LargestDifferenceMm(const RodState& a, const RodState& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.point.size(); ++i) {
    largest = std::max(largest, (a.point[i].position_mm - b.point[i].position_mm).norm());
  }
  return largest;
}

inline bool SameBits(const RodState& a, const RodState& b) {
  for (std::size_t i = 0; i < a.point.size(); ++i) {
    if (a.point[i].position_mm != b.point[i].position_mm) return false;
    if (a.point[i].orientation.coeffs() != b.point[i].orientation.coeffs()) return false;
    if (a.point[i].curvature_per_mm != b.point[i].curvature_per_mm) return false;
  }
  return a.last.base_force_n == b.last.base_force_n && a.last.energy_n_mm == b.last.energy_n_mm;
}

/// Largest distance between neighbours less their spacing: 0 for any shape of an inextensible rod,
/// whose chords are never longer than its arcs.
inline double LongestStretchMm(const RodModel& model, const RodState& state) {
  double longest = 0.0;
  for (std::size_t i = 1; i < state.point.size(); ++i) {
    const double chord = (state.point[i].position_mm - state.point[i - 1].position_mm).norm();
    longest = std::max(longest, chord - model.spacing_mm());
  }
  return longest;
}

}  // namespace acus::needle::testing_support
