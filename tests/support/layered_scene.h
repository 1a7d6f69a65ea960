// A scene in memory: a block of layered tissue under air, its normal along +z, skin at z = 0.
#pragma once

#include <filesystem>

#include "acus/data/volume/labels.h"
#include "acus/scene/simulation/scene.h"

namespace acus::testing_support {

struct Layer {
  double from_z_mm;
  const char* tissue;
  std::int16_t hu;
};

/// Skin, fat, muscle, and bone below 60 mm (for |x| < 10 mm and y > 10 mm only).
inline constexpr Layer kLayers[] = {{0.0, "skin", 20}, {2.0, "fat", -100}, {15.0, "muscle", 55}};

/// The plan of a scene with the given effects, on inputs that are all there.
inline simulation::EffectPlan PlanOf(bool force, bool ultrasound, bool ct_slice, bool needle) {
  scenario::Scenario s;
  s.file = "layers.json";
  s.patient.ct = "ct";
  s.patient.labels = "labels";
  if (force) s.needle_force.emplace();
  if (ultrasound) s.ultrasound.emplace().needle = needle;
  if (ct_slice) s.ct_slice.emplace().needle = needle;
  return simulation::PlanEffects(s, {.needle_poses = true, .probe_poses = true});
}

/// 1 mm voxels: 60 x 60 mm wide, from 10 mm above the skin to 90 mm below it.
inline volume::Geometry LayeredGeometry() {
  volume::Geometry geometry;
  geometry.size = {60, 60, 100};
  geometry.origin_mm = {-29.5, -29.5, -9.5};
  return geometry;
}

/// The presets come from the source tree's configs.
inline simulation::Scene LayeredScene(const simulation::EffectPlan& plan, bool needle_in_images,
                                      const volume::Geometry& geometry = LayeredGeometry()) {
  const std::filesystem::path configs = std::filesystem::path(ACUS_SOURCE_DIR) / "configs";
  simulation::Scene scene;
  scene.plan = plan;
  scene.image_rate_hz = 30.0;
  scene.needle_in_ct_slice = scene.needle_in_b_mode = needle_in_images;
  scene.needle = forces::ReadNeedle(configs / "needles/spinal_22g.json");
  scene.forces.emplace(forces::NeedleForceModel(
      forces::ReadForceTable(configs / "forces/default.json"), *scene.needle));
  scene.probe = acoustics::ReadProbe(configs / "probes/linear_l14.json");
  scene.b_mode = ultrasound::ReadBModeOptions(configs / "acoustics/hu_textured.json");

  auto ct = std::make_shared<volume::CtVolume>(geometry, std::int16_t{-1000});
  auto labels = std::make_shared<volume::LabelMap>(geometry);
  for (int k = 0; k < geometry.size[2]; ++k) {
    const double z_mm = geometry.origin_mm[2] + geometry.spacing_mm[2] * k;
    for (int j = 0; j < geometry.size[1]; ++j) {
      for (int i = 0; i < geometry.size[0]; ++i) {
        const double x_mm = geometry.origin_mm[0] + geometry.spacing_mm[0] * i;
        const double y_mm = geometry.origin_mm[1] + geometry.spacing_mm[1] * j;
        for (const Layer& layer : kLayers) {
          if (z_mm < layer.from_z_mm) continue;
          ct->At(i, j, k) = layer.hu;
          labels->At(i, j, k) = volume::LabelOf(layer.tissue);
        }
        if (z_mm > 60.0 && std::abs(x_mm) < 10.0 && y_mm > 10.0) {
          ct->At(i, j, k) = 900;
          labels->At(i, j, k) = volume::LabelOf("bone");
        }
      }
    }
  }
  for (const auto& label : volume::StandardLabels()) {
    labels->names[label.label] = std::string(label.name);
  }
  scene.labels = std::move(labels);
  scene.ct = std::move(ct);
  return scene;
}

}  // namespace acus::testing_support
