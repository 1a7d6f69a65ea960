// The simulation core: replay and live call the same Step.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "acus/data/volume/volume.h"
#include "acus/physics/breathing/breath.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/physics/forces/force_model.h"
#include "acus/physics/forces/probe_force_model.h"
#include "acus/physics/forces/tissue_lookup.h"
#include "acus/physics/tissue/tissue_model.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// One reading of the tools, in the session's reference frame.
struct Sample {
  std::int64_t time_ns = 0;
  Eigen::Isometry3d reference_from_needle = Eigen::Isometry3d::Identity();
  bool needle_valid = false;
  /// Only read if the probe's force or the tissue that it presses is in the plan.
  Eigen::Isometry3d reference_from_probe = Eigen::Isometry3d::Identity();
  bool probe_valid = false;
  /// In terms of a normal breath. Only read if the session says how the patient breathes.
  breathing::Breath breath = {};
};

/// What one step gives.
struct StepOutput {
  std::int64_t time_ns = 0;
  Eigen::Isometry3d ct_from_needle = Eigen::Isometry3d::Identity();
  /// Where it would lie in the CT: elsewhere only in a patient who breathes.
  breathing::ToolAtRest needle_at_rest;
  volume::Label tissue_at_tip = 0;
  forces::NeedleForce force;
  NeedleShape shape;           ///< Not bent if the plan has no needle shape.
  forces::ProbeForce probe;    ///< Zero if the plan has no probe force.
  tissue::TissueForce tissue;  ///< Zero if the plan has no tissue contact.
  EffectColumns effect{};      ///< What effects of the list write down.
};

/// All that changes. A plain value: save it, restore it, run many side by side. Made by
/// Simulation::NewState.
struct State {
  forces::ForceState force;
  forces::PassedEvents passed;  ///< What happened to the needle in the last step, in order.
  NeedleShapeState shape;       ///< Only used if the plan has the needle's shape.
  forces::ProbeForceState probe;
  tissue::TissueState tissue;         ///< Empty if the plan has no tissue contact.
  std::int64_t session_start_ns = 0;  ///< Breath is a matter of the time since then.
  /// Until then its pose is not looked at: a live session does not know it, a replay does.
  bool needle_seen = false;
  breathing::ToolTrack needle_track;
  breathing::ToolTrack probe_track;
  effects::Memory effects;  ///< Of the effects of the list.
  /// How far these have moved the tissue at the needle's tip.
  Eigen::Vector3d needle_moved_mm = Eigen::Vector3d::Zero();
  std::int64_t steps = 0;
};

/// The const model. Stages that are not in the scene's plan are not run.
class Simulation {
 public:
  /// @param scene  Must outlive the simulation.
  explicit Simulation(const Scene& scene);

  /// @param session_start_ns  Of the first reading of any tool.
  State NewState(std::int64_t session_start_ns = 0) const;

  /// Advances to `sample.time_ns`; what no stage in the plan reads of it may be left out. Allocates
  /// nothing, takes no lock, prints nothing. A sample that is not valid, not finite or not later
  /// than the last one is dealt with by the force model: the force stays finite and bounded.
  /// @param times  If given, what each stage did is added to it; the results stay the same.
  StepOutput Step(State& state, const Sample& sample, StageTimes* times = nullptr) const noexcept;

  /// What the images need to show the tissue as it is after a step. False if nothing deforms it:
  /// then `out` is not written.
  /// @pre the plan has a deformation stage.
  bool LoadOf(const State& state, const StepOutput& output, tissue::TissueLoad& out) const noexcept;

  /// The needle as the images show it after a step, from the tip to the hub, in CT space. False,
  /// and `out` not written, if it is straight where the hand holds it.
  bool ShapeOf(const State& state, math::Polyline& out) const noexcept;

 private:
  /// The tools as they would lie in the CT.
  struct Tools {
    breathing::ToolAtRest needle;
    breathing::ToolAtRest probe;
    std::optional<breathing::MotionMap> patient;  ///< If the scene has breathing.
    bool tissue_moves = false;                    ///< By breath.
    /// d place without effects of the list / d place with them, at the tools.
    Eigen::Matrix3d needle_per_moved = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d probe_per_moved = Eigen::Matrix3d::Identity();
  };
  Tools ToolsOf(State& state, const Sample& sample) const noexcept;
  void LayAtRest(State& state, const Sample& sample, Tools& tools) const noexcept;
  Eigen::Isometry3d PressedProbe(const Tools& tools, bool pressed) const noexcept;
  forces::ProbeForce FeltFromTissue(const tissue::TissueForce& tissue) const noexcept;
  void CarryForces(const Tools& tools, StepOutput& out) const noexcept;
  void ShapeNeedle(State& state, const Sample& sample, const Tools& tools,
                   StepOutput& out) const noexcept;

  const Scene& scene_;
  std::optional<forces::TissueLookup> lookup_;  ///< If the plan looks tissues up.
  bool runs_needle_ = false;
  bool runs_contact_ = false;
  bool runs_force_ = false;
  bool runs_probe_ = false;
  double largest_needle_n_ = 0.0;  ///< Of the model of the needle's force.
  double largest_probe_n_ = 0.0;
};

}  // namespace acus::simulation
