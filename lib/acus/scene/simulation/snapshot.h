// The state at one instant from which an image is rendered.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "acus/base/math/polyline.h"
#include "acus/physics/breathing/breath.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/scene/effects/memory.h"

namespace acus::simulation {

struct Snapshot {
  std::int64_t time_ns = 0;
  double session_s = 0.0;         ///< Time since the session began, which drives the breath ...
  breathing::Breath breath = {};  ///< ... unless the session holds the breath: then this.
  bool probe_valid = false;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  /// Nothing if there is no visible needle.
  std::optional<Eigen::Isometry3d> ct_from_needle = std::nullopt;
  /// As Simulation::ShapeOf gives it; null: straight in the hand. Must live until the image is
  /// rendered.
  const math::Polyline* needle_shape = nullptr;
  Eigen::Vector3d needle_force_in_ct_n = Eigen::Vector3d::Zero();  ///< On the hand; zero: none.
  /// Null if nothing deforms the tissue; must live until the image is rendered.
  const tissue::TissueLoad* load = nullptr;
  /// States of effects after the last step; null if there was none. Must live as long.
  const effects::Memory* memory = nullptr;
  /// Index in ListedEffects::all() of the effect that this snapshot is for; kOfScene: a snapshot
  /// for the scene's images.
  static constexpr std::size_t kOfScene = static_cast<std::size_t>(-1);
  std::size_t of_effect = kOfScene;
};

}  // namespace acus::simulation
