#include "acus/imaging/acoustics/field_of_view.h"

#include <cmath>

namespace acus::acoustics {

double DepthBelowFaceMm(const Probe& probe, const Eigen::Vector2d& place_mm) {
  if (probe.kind == ProbeKind::kLinear) return place_mm.y();
  return std::hypot(place_mm.x(), place_mm.y() + probe.radius_mm) - probe.radius_mm;
}

bool IsInFieldOfView(const Probe& probe, const Eigen::Vector2d& place_mm) {
  constexpr double kRoundingMm = 1e-9;
  const double depth_mm = DepthBelowFaceMm(probe, place_mm);
  if (depth_mm < -kRoundingMm || depth_mm > probe.depth_mm + kRoundingMm) return false;
  if (probe.kind == ProbeKind::kLinear) return std::abs(place_mm.x()) <= 0.5 * probe.width_mm;
  const double angle_rad = std::atan2(place_mm.x(), place_mm.y() + probe.radius_mm);
  return std::abs(angle_rad) <= 0.5 * probe.field_of_view_rad;
}

}  // namespace acus::acoustics
