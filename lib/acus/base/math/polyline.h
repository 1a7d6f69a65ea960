// A line through points, of fixed capacity: it can be made and copied in a real-time step.
#pragma once

#include <Eigen/Core>
#include <array>

namespace acus::math {

/// point_mm[0] to point_mm[num_points - 1], joined by straight pieces. Space and order are the
/// owner's to say. A plain value.
struct Polyline {
  static constexpr int kMaxPoints = 128;

  Polyline() noexcept { point_mm.fill(Eigen::Vector3d::Zero()); }

  std::array<Eigen::Vector3d, kMaxPoints> point_mm;
  int num_points = 0;

  bool empty() const noexcept { return num_points == 0; }
  void Clear() noexcept { num_points = 0; }
  /// Points beyond the capacity are omitted.
  void Add(const Eigen::Vector3d& at_mm) noexcept {
    if (num_points < kMaxPoints) point_mm[static_cast<std::size_t>(num_points++)] = at_mm;
  }
  const Eigen::Vector3d& At(int i) const noexcept { return point_mm[static_cast<std::size_t>(i)]; }
};

}  // namespace acus::math
