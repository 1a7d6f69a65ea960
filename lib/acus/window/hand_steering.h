// Moves the virtual hands with mouse and keyboard.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/rig/haptics/virtual_hand.h"
#include "acus/window/command.h"

namespace acus::window {

/// Speed of a tool while a key is held; a tenth of it with Shift.
inline constexpr double kHeldMmPerS = 30.0;

/// Share of that speed at which keys move a needle, by the distance of its tip to the target: 1
/// from 40 mm on, falling with the distance to an eighth at the target. 1 without a target.
double SpeedShare(const std::optional<double>& tip_to_target_mm) noexcept;

/// Translation and rotation of a tool by `input` within `dt_s`, device frame: along the needle, +z
/// of the tool, and in the direction of the mouse.
struct ToolWay {
  Eigen::Vector3d way_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();

  bool IsZero() const { return way_mm.isZero(0.0) && turn_rad.isZero(0.0); }
};
ToolWay WayOf(const HandInput& input, const Eigen::Isometry3d& device_from_tool, double dt_s,
              double speed_share = 1.0);

/// Moves the goal of the hand that holds a tool. Null: a real hand holds it, and nothing changes.
/// @param may_advance  False: not along the tool, so that the goal stays near a stopped needle.
void Steer(haptics::HandSteering* hand, const Eigen::Isometry3d& handle_from_tool,
           const HandInput& input, double dt_s, bool may_advance = true, double speed_share = 1.0);

}  // namespace acus::window
