// Flat layers for tests of tissue models: skin at z = 0, deeper with z; forces and stiffness with
// round numbers.
#pragma once

#include <bitset>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/tissue_at.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::testing_support {

inline forces::ForceTable RoundForces() {
  return forces::ForceTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-forces/1", "reference_diameter_mm": 1.27, "interface_hysteresis_mm": 0.2,
    "tissues": [
      {"tissue": "soft_tissue", "source": "test", "cutting_n": 0.5, "friction_n_per_mm": 0.02},
      {"tissue": "skin", "source": "test", "a1_n_per_mm": 0.1, "a2_n_per_mm2": 0.05, "puncture_n": 2.1,
       "cutting_n": 1.0, "friction_n_per_mm": 0.03},
      {"tissue": "fat", "source": "test", "cutting_n": 0.4, "friction_n_per_mm": 0.01},
      {"tissue": "liver", "source": "test", "a1_n_per_mm": 0.048, "a2_n_per_mm2": 0.0052,
       "puncture_n": 1.5, "no_membrane_from": ["vessel"], "cutting_n": 0.8, "friction_n_per_mm": 0.015},
      {"tissue": "vessel", "source": "test", "cutting_n": 0.1, "friction_n_per_mm": 0.0},
      {"tissue": "bone", "source": "test", "impenetrable": true}
    ]})"),
                                    "round");
}

inline mechanics::ElasticityTable RoundElasticity() {
  return mechanics::ElasticityTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-elasticity/1",
    "tissues": [
      {"tissue": "skin", "source": "test", "youngs_modulus_kpa": 100},
      {"tissue": "fat", "source": "test", "youngs_modulus_kpa": 10},
      {"tissue": "liver", "source": "test", "youngs_modulus_kpa": 20},
      {"tissue": "vessel", "source": "test", "youngs_modulus_kpa": 20}
    ]})"),
                                            "round");
}

inline forces::NeedleProperties Trocar18() {
  return {
      .name = "18G",
      .gauge = 18,
      .length_mm = 150.0,
      .beam = {.outer_diameter_mm = 1.27, .inner_diameter_mm = 0.84, .youngs_modulus_mpa = 193e3}};
}

/// Tissue from each depth on; the last one that applies.
struct Layers {
  std::vector<std::pair<double, const char*>> from;

  tissue::TissueAt At() const {
    std::vector<std::pair<double, volume::Label>> labels;
    for (const auto& [z_mm, name] : from) labels.emplace_back(z_mm, volume::LabelOf(name));
    return [labels](const Eigen::Vector3d& p) {
      volume::Label tissue = 0;
      for (const auto& [z_mm, label] : labels) {
        if (p.z() >= z_mm) tissue = label;
      }
      return tissue;
    };
  }

  std::bitset<256> Tissues() const {
    std::bitset<256> tissues;
    for (const auto& layer : from) tissues.set(volume::LabelOf(layer.second));
    return tissues;
  }
};

/// A needle driven along a line through a model, with the work that the hand does on it.
template <class Model>
struct ModelInsertion {
  const Model& model;
  decltype(std::declval<const Model&>().NewState()) state = model.NewState();
  double time_s = 0.0;
  Eigen::Vector3d tip_mm = Eigen::Vector3d(0, 0, -1);
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  forces::NeedleForce last{};
  double work_n_mm = 0.0;       ///< Trapezoid: that of the law itself.
  double held_work_n_mm = 0.0;  ///< Force held over each step, as a device does.
  std::vector<forces::NeedleForce> log{};

  const forces::NeedleForce& StepTo(const Eigen::Vector3d& to_mm, double dt_s = 0.001) {
    const Eigen::Vector3d travel_mm = to_mm - tip_mm;
    const Eigen::Vector3d before_n = last.force_in_ct_n;
    tip_mm = to_mm;
    time_s += dt_s;
    tissue::ToolSample sample;
    sample.time_s = time_s;
    sample.tip_in_ct_mm = tip_mm;
    sample.axis_in_ct = axis;
    last = model.Step(state, sample);
    work_n_mm -= 0.5 * (before_n + last.force_in_ct_n).dot(travel_mm);
    held_work_n_mm -= before_n.dot(travel_mm);
    log.push_back(last);
    return last;
  }

  const forces::NeedleForce& MoveTo(const Eigen::Vector3d& end_mm, double speed_mm_per_s = 10.0,
                                    double dt_s = 0.001) {
    const Eigen::Vector3d begin_mm = tip_mm;
    const double steps =
        std::max(1.0, std::ceil((end_mm - begin_mm).norm() / (speed_mm_per_s * dt_s)));
    for (double i = 1; i <= steps; ++i) {
      StepTo(begin_mm + (end_mm - begin_mm) * (i / steps), dt_s);
    }
    return last;
  }
  const forces::NeedleForce& MoveToDepth(double z_mm, double speed_mm_per_s = 10.0,
                                         double dt_s = 0.001) {
    return MoveTo(Eigen::Vector3d(tip_mm.x(), tip_mm.y(), z_mm), speed_mm_per_s, dt_s);
  }

  int Count(forces::NeedleEvent event) const {
    int count = 0;
    for (const forces::NeedleForce& force : log) count += force.event == event ? 1 : 0;
    return count;
  }
};

}  // namespace acus::testing_support
