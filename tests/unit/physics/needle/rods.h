// Rods that several tests use.
#pragma once

#include <span>

#include "acus/physics/needle/rod.h"

namespace acus::needle::testing_support {

inline constexpr double kLengthMm = 150.0;
inline constexpr double kBending = 51200.0;  ///< A 16-gauge steel tube of regular wall, N mm^2.
inline constexpr double kTwist = kBending / 1.3;

inline RodModel Rod(int num_nodes, double tolerance_mm = 1e-3) {
  RodProperties properties;
  properties.length_mm = kLengthMm;
  properties.bending_n_mm2 = kBending;
  properties.twist_n_mm2 = kTwist;
  RodOptions options;
  options.num_nodes = num_nodes;
  options.tolerance_mm = tolerance_mm;
  options.max_contacts = 4 * num_nodes;
  return {properties, options};
}

inline RodLoad TipLoad(const Eigen::Vector3d& force_n) {
  return {kLengthMm, force_n};
}

inline Eigen::Vector3d TipMm(const RodState& state) {
  return state.point.back().position_mm;
}

/// Tissue along the needle from `from_mm` to its tip: a spring in the middle of each piece of
/// `num_pieces`, to the straight channel along +z of a rod whose base is at the origin.
inline std::vector<RodContact> Channel(double from_mm, int num_pieces, double stiffness_n_per_mm2) {
  std::vector<RodContact> channel;
  const double piece_mm = (kLengthMm - from_mm) / num_pieces;
  for (int i = 0; i < num_pieces; ++i) {
    RodContact contact;
    contact.arc_mm = from_mm + (i + 0.5) * piece_mm;
    contact.anchor_mm = {0.0, 0.0, contact.arc_mm};
    contact.free_axis = Eigen::Vector3d::UnitZ();
    contact.stiffness_n_per_mm = stiffness_n_per_mm2 * piece_mm;
    channel.push_back(contact);
  }
  return channel;
}

inline RodInput Input(std::span<const RodContact> contacts, std::span<const RodLoad> loads = {}) {
  RodInput input;
  input.contacts = contacts;
  input.loads = loads;
  return input;
}

}  // namespace acus::needle::testing_support
