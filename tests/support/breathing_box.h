// A box of tissue whose motion is known: linear in place, signal and rate.
#pragma once

#include <cmath>
#include <numbers>

#include "acus/physics/breathing/model_building.h"

namespace acus::testing_support {

inline volume::Geometry BreathingNodes() {
  volume::Geometry nodes;
  nodes.size = {6, 5, 7};
  nodes.spacing_mm = {20, 25, 15};
  nodes.origin_mm = {-40, -60, 10};
  return nodes;
}

/// Shape of the part that follows the signal, and of the part that follows its rate.
inline Eigen::Vector3d LevelShapeMm(const Eigen::Vector3d& place_mm) {
  return {0.01 * place_mm[1], -2.0 + 0.02 * place_mm[2], 12.0 + 0.05 * place_mm[0]};
}
inline Eigen::Vector3d RateShapeMm(const Eigen::Vector3d& place_mm) {
  return {1.0, 0.01 * place_mm[0], 0.02 * place_mm[2]};
}

/// Breath `share` of the way through a regular cycle of 4 s: level 1 at inspiration, 0 half way.
inline breathing::Breath RegularBreath(double share, double depth = 1.0) {
  const double angle = 2.0 * std::numbers::pi * share;
  return {.cycle = share - std::floor(share),
          .level = 1.0 - depth * (0.5 - 0.5 * std::cos(angle)),
          .level_per_s = -depth * 0.25 * std::numbers::pi * std::sin(angle)};
}

/// How far tissue is from the reference, at end inspiration.
inline Eigen::Vector3d TrueDisplacementMm(const breathing::Breath& breath,
                                          const Eigen::Vector3d& place_mm, double hysteresis) {
  return (1.0 - breath.level) * LevelShapeMm(place_mm) +
         hysteresis * breath.level_per_s * RateShapeMm(place_mm);
}

inline std::vector<float> TrueField(const breathing::Breath& breath, double hysteresis) {
  const volume::Geometry nodes = BreathingNodes();
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  std::vector<float> values;
  for (int k = 0; k < nodes.size[2]; ++k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        for (const double mm :
             TrueDisplacementMm(breath, ct_from_index * Eigen::Vector3d(i, j, k), hysteresis)) {
          values.push_back(static_cast<float>(mm));
        }
      }
    }
  }
  return values;
}

/// `count` phases of one breath; the first one is the reference.
inline breathing::MotionPhases TruePhases(int count, double hysteresis = 1.0, double depth = 1.0) {
  breathing::MotionPhases phases{.nodes = BreathingNodes(), .phases = {}};
  for (int j = 0; j < count; ++j) {
    const auto breath = RegularBreath(static_cast<double>(j) / count, depth);
    phases.phases.push_back({.breath = breath, .displacement_in_ct_mm = {}});
    if (j > 0) phases.phases.back().displacement_in_ct_mm = TrueField(breath, hysteresis);
  }
  return phases;
}

}  // namespace acus::testing_support
