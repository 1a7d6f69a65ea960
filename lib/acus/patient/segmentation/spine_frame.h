// Where points are along a spine: by the line of its canal and the planes of its discs.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/patient/segmentation/spine/disc_planes.h"

namespace acus::segmentation {

/// Where a point is along the spine.
struct SpinePlace {
  std::size_t step = 0;
  double left_mm = 0.0, forward_mm = 0.0;
};

/// The core of a body, from the canal's middle; growth of vertebrae starts there.
struct BodyCore {
  static constexpr double kHalfWidthMm = 12.0;
  static constexpr double kFromMm = 11.0;
  static constexpr double kToMm = 28.0;

  static bool Has(const SpinePlace& place) {
    return std::abs(place.left_mm) <= kHalfWidthMm && place.forward_mm >= kFromMm &&
           place.forward_mm <= kToMm;
  }
};

/// @pre the line has points; line and discs outlive the frame.
class SpineFrame {
 public:
  SpineFrame(const CanalLine& line, const std::vector<DiscPlane>& discs)
      : line_(line), discs_(discs) {}

  SpinePlace PlaceOf(const Eigen::Vector3d& p) const {
    // The line runs upwards, nearly along that axis.
    const Eigen::Vector3d up = line_.axes.col(2);
    const Eigen::Vector3d& bottom = line_.points_mm.front();
    const double length_mm = up.dot(line_.points_mm.back() - bottom);
    const auto last = static_cast<double>(line_.points_mm.size() - 1);
    double at = std::clamp(up.dot(p - bottom) / length_mm, 0.0, 1.0) * last;
    for (int round = 0; round < 4; ++round) {
      const auto s = static_cast<std::size_t>(std::lround(at));
      at = std::clamp(at + (p - line_.points_mm[s]).dot(line_.tangent[s]) / line_.step_mm, 0.0,
                      last);
    }
    SpinePlace place;
    place.step = static_cast<std::size_t>(std::lround(at));
    const Eigen::Vector3d d = p - line_.points_mm[place.step];
    place.left_mm = d.dot(line_.Left(place.step));
    place.forward_mm = d.dot(line_.forward[place.step]);
    return place;
  }

  /// Vertebrae are numbered from the feet here: n lies above disc n - 1 and below disc n. -1 near a
  /// disc's plane, or too far beyond the last one.
  int Between(const Eigen::Vector3d& p) const {
    int number = 0;
    for (const DiscPlane& disc : discs_) {
      const double above = (p - disc.point_mm).dot(disc.normal);
      if (std::abs(above) < kPlateMm) return -1;
      if (above > 0.0) ++number;
    }
    const auto beyond = [&](const DiscPlane& disc) {
      return std::abs((p - disc.point_mm).dot(disc.normal)) > kEndMm;
    };
    if (number == 0 && beyond(discs_.front())) return -1;
    if (number == static_cast<int>(discs_.size()) && beyond(discs_.back())) return -1;
    return number;
  }

 private:
  static constexpr double kPlateMm = 2.0;  ///< The core keeps away from the discs' planes.
  static constexpr double kEndMm = 45.0;   ///< Beyond the last disc; no vertebra is higher.

  const CanalLine& line_;
  const std::vector<DiscPlane>& discs_;  ///< From the feet to the head.
};

}  // namespace acus::segmentation
