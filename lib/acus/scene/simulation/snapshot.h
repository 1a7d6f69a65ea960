// What an image needs to know of a moment.
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
  double session_s = 0.0;         ///< Since the session began: what breath goes by ...
  breathing::Breath breath = {};  ///< ... unless the session says it: then this.
  bool probe_valid = false;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  /// Nothing if there is no needle to see.
  std::optional<Eigen::Isometry3d> ct_from_needle = std::nullopt;
  /// As Simulation::ShapeOf gives it; null: straight in the hand. Must live until the image is
  /// made.
  const math::Polyline* needle_shape = nullptr;
  Eigen::Vector3d needle_force_in_ct_n = Eigen::Vector3d::Zero();  ///< On the hand; zero: none.
  /// Null if nothing deforms the tissue; must live until the image is made.
  const tissue::TissueLoad* load = nullptr;
  /// Of effects, after the last step; null if there was none. The same.
  const effects::Memory* memory = nullptr;
  /// Place in ListedEffects::all() of the effect whose own moment this is; kOfScene: a moment of
  /// the scene's images.
  static constexpr std::size_t kOfScene = static_cast<std::size_t>(-1);
  std::size_t of_effect = kOfScene;
};

}  // namespace acus::simulation
