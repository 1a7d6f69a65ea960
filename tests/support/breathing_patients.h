// The same breathing patient by every motion model, at any resolution of the field: what the cost
// and the stability of breathing are measured on.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "acus/physics/breathing/model_building.h"
#include "acus/scene/simulation/breathing_scene.h"

namespace acus::testing_support {

inline constexpr std::array kAllMotionKinds = {
    breathing::MotionKind::kSinusoid, breathing::MotionKind::kFullCycle,
    breathing::MotionKind::kHalfCycle, breathing::MotionKind::kSurrogate};

/// Tissue moves towards the feet and a little forwards with the level, sideways with its rate: most
/// in the middle of the box, not at all at its faces.
struct BreathingPatient {
  breathing::MotionKind kind = breathing::MotionKind::kFullCycle;
  int nodes_per_axis = 64;
  volume::Geometry box = {};
  double largest_mm = 20.0;    ///< At end expiration, in the middle of the box.
  double hysteresis_mm = 3.0;  ///< Half the width of the loop.
  double period_s = 4.0;
  Eigen::Vector3d towards = Eigen::Vector3d(0.0, -0.3, -1.0);  ///< In parts of largest_mm.
  Eigen::Vector3d sideways = Eigen::Vector3d::UnitX();

  double ShapeAt(const Eigen::Vector3d& place_mm) const {
    const Eigen::Array3d length_mm = box.spacing_mm * (box.size - 1).cast<double>();
    const Eigen::Array3d share = (place_mm - box.origin_mm).array() / length_mm;
    return (share.max(0.0).min(1.0) * std::numbers::pi).sin().prod();
  }
  /// What `breath` does to tissue that is at a place at end inspiration.
  Eigen::Vector3d DisplacementMm(const breathing::Breath& breath,
                                 const Eigen::Vector3d& place_mm) const {
    return ShapeAt(place_mm) * AmountMm(breath);
  }
  breathing::Breath BreathAt(double cycle) const {
    const double angle = 2.0 * std::numbers::pi * cycle;
    return {.cycle = cycle,
            .level = 0.5 + 0.5 * std::cos(angle),
            .level_per_s = -std::numbers::pi / period_s * std::sin(angle)};
  }

  simulation::Breathing Make() const {
    return {.motion = {.name = "patient", .model = Model(), .period_s = period_s},
            .source = {breathing::BreathingPattern({.period_s = period_s, .exponent = 1}), {}}};
  }

  breathing::MotionModel Model() const {
    using breathing::KeyFrame;
    using breathing::MotionModel;
    const Eigen::Vector3d rate_mm = hysteresis_mm * period_s / std::numbers::pi * sideways;
    switch (kind) {
      case breathing::MotionKind::kSinusoid:
        return MotionModel::Sinusoid(Field({largest_mm * towards}), 1.0);
      case breathing::MotionKind::kFullCycle:
        return MotionModel::FullCycle(
            Field({AmountMm(BreathAt(0.25)), AmountMm(BreathAt(0.5)), AmountMm(BreathAt(0.75))}),
            {{0.0, KeyFrame::kReference}, {0.25, 0}, {0.5, 1}, {0.75, 2}});
      case breathing::MotionKind::kHalfCycle:
        return MotionModel::HalfCycle(Field({0.5 * largest_mm * towards, largest_mm * towards}),
                                      {{1.0, KeyFrame::kReference}, {0.5, 0}, {0.0, 1}});
      case breathing::MotionKind::kSurrogate:
        break;
    }
    return MotionModel::Surrogate(Field({-largest_mm * towards, rate_mm, largest_mm * towards}));
  }

 private:
  Eigen::Vector3d AmountMm(const breathing::Breath& breath) const {
    return (1.0 - breath.level) * largest_mm * towards +
           hysteresis_mm * period_s / std::numbers::pi * breath.level_per_s * sideways;
  }

  /// One component for each vector: the shape times it.
  breathing::MotionField Field(const std::vector<Eigen::Vector3d>& amounts_mm) const {
    const volume::Geometry nodes = breathing::NodesOver(box, nodes_per_axis);
    breathing::MotionField field(nodes, static_cast<int>(amounts_mm.size()));
    std::vector<double> bell;  // Of one axis: the shape is a product, as a field of 256^3 is large.
    for (int n = 0; n < nodes_per_axis; ++n) {
      bell.push_back(std::sin(std::numbers::pi * n / (nodes_per_axis - 1)));
    }
    for (int component = 0; const Eigen::Vector3d& amount_mm : amounts_mm) {
      // Micrometres, or coarser where as many do not fit into 16 bits.
      const double mm_per_unit = std::max(1e-3, amount_mm.cwiseAbs().maxCoeff() / 32767.0);
      std::vector<std::int16_t> values;
      values.reserve(3 * nodes.num_voxels());
      for (const double along_k : bell) {
        for (const double along_j : bell) {
          const Eigen::Vector3d units = along_k * along_j / mm_per_unit * amount_mm;
          for (const double along_i : bell) {
            for (const double unit : units) {
              values.push_back(static_cast<std::int16_t>(along_i * unit));
            }
          }
        }
      }
      field.SetStored(component++, values, mm_per_unit);
    }
    return field;
  }
};

}  // namespace acus::testing_support
