// A layered body for force models of every kind, by label and by HU, and their drivers.
#pragma once

#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "acus/physics/forces/models/alamilla_model.h"
#include "acus/physics/forces/models/measured_forces.h"
#include "acus/physics/forces/models/measured_model.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/forces/models/vidal_model.h"
#include "acus/physics/forces/probe/multi_proxy_probe.h"
#include "acus/physics/forces/probe/vidal_probe.h"
#include "references/closed_loop.h"

namespace acus::testing_support {

struct BodyLayer {
  double from_z_mm;
  const char* tissue;
  double hu;
};

/// Skin at z = 0, the needle goes in along +z; HU go over from layer to layer within 2 mm.
class LayeredBodyField : public forces::HuField {
 public:
  explicit LayeredBodyField(std::vector<BodyLayer> layers) : layers_(std::move(layers)) {
    for (const BodyLayer& layer : layers_) labels_.push_back(volume::LabelOf(layer.tissue));
  }
  double HuAt(const Eigen::Vector3d& place) const noexcept override {
    double hu = -1000.0;
    for (const BodyLayer& layer : layers_) {
      const double share = std::clamp(0.5 * (place.z() - layer.from_z_mm) + 0.5, 0.0, 1.0);
      hu += share * (layer.hu - hu);
    }
    return hu;
  }
  double ResolutionMm() const noexcept override { return 0.7; }
  volume::Label LabelAt(const Eigen::Vector3d& place) const noexcept {
    volume::Label label = 0;
    for (std::size_t i = 0; i < layers_.size(); ++i) {
      if (place.z() >= layers_[i].from_z_mm) label = labels_[i];
    }
    return label;
  }

 private:
  std::vector<BodyLayer> layers_;
  std::vector<volume::Label> labels_;
};

inline LayeredBodyField Abdomen() {
  return LayeredBodyField(
      {{0.0, "skin", 20}, {2.0, "fat", -100}, {15.0, "muscle", 55}, {35.0, "bone", 900}});
}

inline forces::NeedleProperties Trocar18G() {
  return {
      .name = "18G",
      .gauge = 18,
      .length_mm = 150.0,
      .beam = {.outer_diameter_mm = 1.27, .inner_diameter_mm = 0.84, .youngs_modulus_mpa = 193e3}};
}

inline forces::ForceTable ShippedTable(const char* name) {
  return forces::ReadForceTable(std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "forces" /
                                name);
}

/// One needle of a model in a body: from a tip to a force.
template <typename Model, typename State>
struct Driven {
  const Model& model;
  const LayeredBodyField& body;
  State state{};
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  forces::NeedleForce last{};

  const forces::NeedleForce& Step(double time_s, const Eigen::Vector3d& tip_mm) {
    last = model.Step(state, {time_s, tip_mm, axis, body.LabelAt(tip_mm), true});
    return last;
  }
  forces::ForceOfPlace Loop() {
    return [this](double time_s, const Eigen::Vector3d& tip_mm) {
      return Step(time_s, tip_mm).force_in_ct_n;
    };
  }
};
using DrivenLayered = Driven<forces::NeedleForceModel, forces::NeedleForceState>;
using DrivenAlamilla = Driven<forces::AlamillaModel, forces::AlamillaState>;
using DrivenVidal = Driven<forces::VidalModel, forces::VidalState>;
using DrivenMeasured = Driven<forces::MeasuredModel, forces::MeasuredState>;

/// The probe pressed into the body, its face's normal along +z.
template <typename Model, typename State>
struct DrivenTool {
  const Model& model;
  State state{};
  forces::ProbeForce last{};
  Eigen::Matrix3d ct_from_tool_turn = BeamAlongZ();

  /// +y of the tool, the beam, along +z.
  static Eigen::Matrix3d BeamAlongZ() {
    return Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  }
  const forces::ProbeForce& Step(double time_s, const Eigen::Vector3d& place_mm) {
    forces::ProbeInput input;
    input.time_s = time_s;
    input.ct_from_probe.linear() = ct_from_tool_turn;
    input.ct_from_probe.translation() = place_mm;
    last = model.Step(state, input);
    return last;
  }
  forces::ForceOfPlace Loop() {
    return [this](double time_s, const Eigen::Vector3d& place_mm) {
      return Step(time_s, place_mm).force_in_ct_n;
    };
  }
};
using DrivenProbe = DrivenTool<forces::VidalProbe, forces::VidalProbeState>;
using DrivenPalpation = DrivenTool<forces::MultiProxyProbe, forces::MultiProxyState>;

/// What the block multi_proxy of a table makes of a field in HU.
inline forces::PalpationFields FieldsOf(const forces::ForceTable& table,
                                        const forces::HuField& field) {
  forces::PalpationFields fields{&field, table.multi_proxy.skin_hu, {}};
  for (const auto& law : table.multi_proxy.structures) {
    if (law.from_hu) fields.structures.push_back({&field, *law.from_hu, law});
  }
  return fields;
}

}  // namespace acus::testing_support
