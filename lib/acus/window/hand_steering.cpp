#include "acus/window/hand_steering.h"

#include <algorithm>

namespace acus::window {

double SpeedShare(const std::optional<double>& tip_to_target_mm) noexcept {
  constexpr double kFarMm = 40.0;
  constexpr double kAtTarget = 0.125;
  if (!tip_to_target_mm) return 1.0;
  return std::clamp(*tip_to_target_mm / kFarMm, kAtTarget, 1.0);
}

ToolWay WayOf(const HandInput& input, const Eigen::Isometry3d& device_from_tool, double dt_s,
              double speed_share) {
  const double held_mm = kHeldMmPerS * speed_share * dt_s * (input.fine ? 0.1 : 1.0);
  const Eigen::Vector3d along = device_from_tool.linear().col(2);
  ToolWay way;
  way.way_mm = input.moved_mm + held_mm * Eigen::Vector3d(input.held.x(), input.held.y(), 0.0) +
               (input.advanced_mm + held_mm * input.held_advance) * along;
  way.turn_rad = input.turned_rad;
  return way;
}

void Steer(haptics::HandSteering* hand, const Eigen::Isometry3d& handle_from_tool,
           const HandInput& input, double dt_s, bool may_advance, double speed_share) {
  if (hand == nullptr) return;
  const Eigen::Isometry3d device_from_tool = hand->goal() * handle_from_tool;
  ToolWay way = WayOf(input, device_from_tool, dt_s, speed_share);
  const Eigen::Vector3d along = device_from_tool.linear().col(2);
  if (!may_advance) way.way_mm -= std::max(0.0, way.way_mm.dot(along)) * along;
  if (!way.IsZero()) hand->Nudge(way.way_mm, way.turn_rad);
}

}  // namespace acus::window
