// What goes into a step, what comes out, and all that changes in between.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "acus/data/volume/volume.h"
#include "acus/physics/breathing/breath.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "acus/physics/forces/models/force_model.h"
#include "acus/physics/forces/probe/probe_force_model.h"
#include "acus/physics/tissue/tissue_model.h"
#include "acus/scene/simulation/listed_effects.h"
#include "acus/scene/simulation/needle_shape.h"

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
  double plunger_n = 0.0;  ///< Force of the thumb on the plunger of a syringe.
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

}  // namespace acus::simulation
