// Input and output of a step, and the state between steps.
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
  /// Relative to a normal breath. Only read if the breath comes from the session.
  breathing::Breath breath = {};
  double plunger_n = 0.0;  ///< Force of the thumb on the plunger of a syringe.
};

/// The results of one step.
struct StepOutput {
  std::int64_t time_ns = 0;
  Eigen::Isometry3d ct_from_needle = Eigen::Isometry3d::Identity();
  /// The pose at rest in the CT: differs only in a patient who breathes.
  breathing::ToolAtRest needle_at_rest;
  volume::Label tissue_at_tip = 0;
  forces::NeedleForce force;
  NeedleShape shape;           ///< Not bent if the plan has no needle shape.
  forces::ProbeForce probe;    ///< Zero if the plan has no probe force.
  tissue::TissueForce tissue;  ///< Zero if the plan has no tissue contact.
  EffectColumns effect{};      ///< Columns of the effects of the list.
  /// Share of `force` that effects of the list add; always finite.
  Eigen::Vector3d added_in_ct_n = Eigen::Vector3d::Zero();
};

/// The state between steps. A plain value: save it, restore it, run many in parallel. Made by
/// Simulation::NewState.
struct State {
  forces::ForceState force;
  forces::PassedEvents passed;  ///< Events of the needle in the last step, in order.
  NeedleShapeState shape;       ///< Only used if the plan has the needle's shape.
  forces::ProbeForceState probe;
  tissue::TissueState tissue;         ///< Empty if the plan has no tissue contact.
  std::int64_t session_start_ns = 0;  ///< Breath depends on the time since then.
  /// The needle's pose is ignored until then, so that replays equal live sessions.
  bool needle_seen = false;
  breathing::ToolTrack needle_track;
  breathing::ToolTrack probe_track;
  effects::Memory effects;  ///< States of the effects of the list.
  /// Displacement of the tissue at the needle's tip by these.
  Eigen::Vector3d needle_moved_mm = Eigen::Vector3d::Zero();
  std::int64_t steps = 0;
};

}  // namespace acus::simulation
