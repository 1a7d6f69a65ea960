// A flat layered body for the force tests: skin at z = 0, the needle goes in along +z.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "acus/physics/forces/models/needle_force.h"

namespace acus::forces {

inline const std::filesystem::path kConfigs = std::filesystem::path(ACUS_SOURCE_DIR) / "configs";

struct LayeredBody {
  struct Layer {
    double from_mm;
    volume::Label tissue;
  };
  std::vector<Layer> layers;

  volume::Label At(double z_mm) const {
    volume::Label tissue = 0;
    for (const Layer& layer : layers) {
      if (z_mm >= layer.from_mm) tissue = layer.tissue;
    }
    return tissue;
  }
};

/// Drives one needle along the z axis through a body, keeping the work that the hand does on it.
struct Insertion {
  const NeedleForceModel& model;
  LayeredBody body;
  NeedleForceState state{};
  double time_s = 0.0;
  double z_mm = -1.0;
  Eigen::Vector2d aside_mm = Eigen::Vector2d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  NeedleForce last{};
  double work_n_mm = 0.0;       ///< Trapezoid: that of the law itself.
  double held_work_n_mm = 0.0;  ///< Force held over each step, as a device at this rate does.
  std::vector<NeedleForce> log{};

  const NeedleForce& StepTo(double new_z_mm, double dt_s = 0.001) {
    const double before_n = last.AxialN();
    const double travel_mm = new_z_mm - z_mm;
    z_mm = new_z_mm;
    time_s += dt_s;
    last =
        model.Step(state, {time_s, {aside_mm.x(), aside_mm.y(), z_mm}, axis, body.At(z_mm), true});
    work_n_mm += 0.5 * (before_n + last.AxialN()) * travel_mm;
    held_work_n_mm += before_n * travel_mm;
    log.push_back(last);
    return last;
  }

  /// At constant speed, to exactly `end_mm`.
  const NeedleForce& MoveTo(double end_mm, double speed_mm_per_s = 5.0, double dt_s = 0.001) {
    const double begin_mm = z_mm;
    const int steps = std::max(
        1, static_cast<int>(std::ceil(std::abs(end_mm - begin_mm) / (speed_mm_per_s * dt_s))));
    for (int i = 1; i <= steps; ++i) StepTo(begin_mm + (end_mm - begin_mm) * i / steps, dt_s);
    return last;
  }

  int Count(NeedleEvent event) const {
    int count = 0;
    for (const NeedleForce& force : log) count += force.event == event ? 1 : 0;
    return count;
  }
};

/// A table with round numbers: "skin" with a membrane, "fat" plain, "liver" with a capsule, bone.
inline ForceTable SimpleTable() {
  return ForceTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-forces/1", "reference_diameter_mm": 1.27, "interface_hysteresis_mm": 0.2,
    "bone": {"stiffness_n_per_mm": 10},
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
                            "simple");
}

inline NeedleProperties Trocar() {
  return {
      .name = "18G",
      .gauge = 18,
      .length_mm = 150.0,
      .beam = {.outer_diameter_mm = 1.27, .inner_diameter_mm = 0.84, .youngs_modulus_mpa = 193e3}};
}

}  // namespace acus::forces
