// A snapshot of a live session, for threads that render it.
#pragma once

#include <optional>

#include "acus/base/math/polyline.h"
#include "acus/data/session/signals.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::live {

/// A plain value of fixed size that points to nothing: it can be copied from thread to thread.
struct LiveSnapshot {
  /// Without shape and load: see ForRenderer().
  simulation::Snapshot moment;
  bool has_shape = false;
  math::Polyline shape;
  bool has_load = false;
  tissue::TissueLoad load;
  bool has_memory = false;
  effects::Memory memory;  ///< States of the effects of the list.

  simulation::StepOutput output;
  bool needle_valid = false;
  double needle_force_n = 0.0;  ///< Requested from the device; its guard may reduce it.
  double probe_force_n = 0.0;
  session::BreathSample breath;
  bool breath_held = false;
  bool frozen = false;
  bool hands_swapped = false;
  bool forces_paused = false;
  std::optional<double> gain_db;   ///< Of the probe; nothing if not changed.
  std::optional<double> depth_mm;  ///< The same.
  double plunger_n = 0.0;          ///< Force of the thumb on the plunger of a syringe, as ordered.
  std::optional<Eigen::Vector3d> target_in_ct_mm;
  /// CLOCK_MONOTONIC, ns: when the probe's pose (else the needle's) was measured.
  std::int64_t measured_ns = 0;

  /// The snapshot for image renderers. Valid as long as this is neither moved nor changed.
  simulation::Snapshot ForRenderer() const {
    simulation::Snapshot out = moment;
    if (has_shape) out.needle_shape = &shape;
    if (has_load) out.load = &load;
    if (has_memory) out.memory = &memory;
    return out;
  }
};

}  // namespace acus::live
