// Planes that cut a view in three dimensions open.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <span>

namespace acus::volume_rendering {

/// CT space, mm. What lies on its positive side is not shown; tools are.
using CutPlane = Eigen::Hyperplane<double, 3>;

inline bool IsCutAway(std::span<const CutPlane> cuts, const Eigen::Vector3d& place_mm) {
  return std::ranges::any_of(
      cuts, [&](const CutPlane& plane) { return plane.signedDistance(place_mm) > 0.0; });
}

/// The part of a ray, in mm from the eye, that no plane cuts away; far_mm < near_mm: none of it.
struct ShownPart {
  double near_mm = 0.0;
  double far_mm = std::numeric_limits<double>::max();
};
inline ShownPart ShownPartOf(std::span<const CutPlane> cuts, const Eigen::Vector3d& eye_mm,
                             const Eigen::Vector3d& direction) {
  ShownPart part;
  for (const CutPlane& plane : cuts) {
    const double height_mm = plane.signedDistance(eye_mm);
    const double rise = plane.normal().dot(direction);
    if (rise < 0.0) {
      part.near_mm = std::max(part.near_mm, -height_mm / rise);
    } else if (rise > 0.0) {
      part.far_mm = std::min(part.far_mm, -height_mm / rise);
    } else if (height_mm > 0.0) {
      part.far_mm = -1.0;
    }
  }
  return part;
}

}  // namespace acus::volume_rendering
