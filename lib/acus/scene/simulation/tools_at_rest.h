// Tools in tissue that moves by itself: where they would lie in the CT, and what the forces there
// are in the patient.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/physics/breathing/motion_map.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/step_state.h"

namespace acus::simulation {

/// The tools of a step as they would lie in the CT.
struct ToolsAtRest {
  breathing::ToolAtRest needle;
  breathing::ToolAtRest probe;
  std::optional<breathing::MotionMap> patient;  ///< If the scene has breathing.
  bool tissue_moves = false;                    ///< By breath.
  /// d place without effects of the list / d place with them, at the tools.
  Eigen::Matrix3d needle_per_moved = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d probe_per_moved = Eigen::Matrix3d::Identity();
};

/// @param press_mm  Deeper than recorded, as the probe's force asks for.
Eigen::Isometry3d PressedProbe(const ToolsAtRest& tools, double press_mm) noexcept;

/// Const after construction. Real time: nothing here allocates, locks, logs or throws.
class ToolMotion {
 public:
  /// @param scene  Must outlive this.
  explicit ToolMotion(const Scene& scene);

  ToolsAtRest Lay(State& state, const Sample& sample) const noexcept;

  /// From the tissue at rest to the patient, by the same work: what effects of the list moved, then
  /// breath. No larger than the models' own limits.
  void CarryForces(const ToolsAtRest& tools, StepOutput& out) const noexcept;

 private:
  void LayInBreath(State& state, const Sample& sample, ToolsAtRest& tools) const noexcept;
  Eigen::Vector3d LayInEffects(const State& state, breathing::ToolAtRest& tool,
                               Eigen::Matrix3d& per_moved) const noexcept;

  const Scene& scene_;
  bool has_needle_ = false;
  bool has_probe_ = false;
  double largest_needle_n_ = 0.0;  ///< Of the model of the needle's force.
  double largest_probe_n_ = 0.0;
};

}  // namespace acus::simulation
