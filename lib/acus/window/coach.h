// One line for the trainee: the first obstacle to the insertion, with the key or the movement that
// removes it.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "acus/run/training/checklist.h"
#include "acus/run/training/situation.h"

namespace acus::window {

/// A tool and how mouse and keys move it.
struct SteeredTool {
  bool is_virtual = false;  ///< Keys move it; else a real hand does.
  bool is_selected = false;
  Eigen::Matrix3d device_from_ct = Eigen::Matrix3d::Identity();  ///< Rotation.
  Eigen::Vector3d along_in_ct = Eigen::Vector3d::UnitZ();        ///< Direction of Page Down. Unit.
};

/// The inputs of the coach.
struct CoachView {
  bool switch_is_open = false;
  bool has_needle = false;
  bool has_probe = false;
  bool wants_plane = false;  ///< The exercise requires the needle in the image plane.
  training::Situation now;
  std::optional<double> gap_to_skin_mm;  ///< In front of the probe's face; nothing: no skin there.
  double probe_depth_mm = 0.0;           ///< Of the probe's face below the skin at rest.
  /// From the tip, in the CT; nothing: the exercise has no target.
  std::optional<Eigen::Vector3d> tip_to_target_in_ct_mm;
  double target_radius_mm = 3.0;
  std::optional<training::StepCondition> next;  ///< Of the exercise's next step.
  bool breath_held = false;
  training::ImageField field;
  double half_thickness_mm = 2.0;                               ///< Of the image plane.
  Eigen::Matrix3d ct_from_probe = Eigen::Matrix3d::Identity();  ///< Rotation.
  SteeredTool needle;
  SteeredTool probe;
};

/// Empty: no obstacle. In this order: switch, probe not seen, no contact, target out of view
/// (plane, side, depth), needle not seen, needle out of the image plane, needle not aimed at the
/// target.
std::string CoachLine(const CoachView& view);

/// How to do the next step of the exercise, once there is no obstacle: the key of a virtual hand,
/// or the movement. Empty: there is no step, or it is done without a movement.
std::string HowTo(const CoachView& view);

/// The key that moves a tool best in a direction, in English: "Page Down", "Left". @param
/// direction_in_ct  Not zero.
std::string KeyTowards(const SteeredTool& tool, const Eigen::Vector3d& direction_in_ct);

}  // namespace acus::window
