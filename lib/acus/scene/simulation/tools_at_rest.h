// Tools in tissue that moves by itself: their poses in the CT at rest, and the forces there, mapped
// into the patient.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/physics/breathing/motion_map.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/step_state.h"

namespace acus::simulation {

/// The tools of a step, mapped to rest in the CT.
struct ToolsAtRest {
  breathing::ToolAtRest needle;
  breathing::ToolAtRest probe;
  std::optional<breathing::MotionMap> patient;  ///< If the scene has breathing.
  bool tissue_moves = false;                    ///< By breath.
  /// Derivative of the position without effects of the list by that with them, at the tools.
  Eigen::Matrix3d needle_per_moved = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d probe_per_moved = Eigen::Matrix3d::Identity();
};

/// @param press_mm  Additional depth, relative to the recording, of the probe's force.
Eigen::Isometry3d PressedProbe(const ToolsAtRest& tools, double press_mm) noexcept;

/// Const after construction. Real time: nothing here allocates, locks, logs or throws.
class ToolMotion {
 public:
  /// @param scene  Must outlive this.
  explicit ToolMotion(const Scene& scene);

  ToolsAtRest Lay(State& state, const Sample& sample) const noexcept;

  /// Maps forces from the tissue at rest to the patient, by equal work: first the motion by effects
  /// of the list, then breath. Limited to the models' largest forces.
  void CarryForces(const ToolsAtRest& tools, StepOutput& out) const noexcept;

 private:
  void LayInBreath(State& state, const Sample& sample, ToolsAtRest& tools) const noexcept;
  Eigen::Vector3d LayInEffects(const State& state, breathing::ToolAtRest& tool,
                               Eigen::Matrix3d& per_moved) const noexcept;

  const Scene& scene_;
  bool has_needle_ = false;
  bool has_probe_ = false;
  double largest_needle_n_ = 0.0;  ///< Largest force of the model of the needle's force.
  double largest_probe_n_ = 0.0;
};

}  // namespace acus::simulation
