#include "acus/window/patient_on_display.h"

#include <algorithm>

#include "acus/data/volume/volume_io.h"
#include "acus/scene/effects/view_3d/patient_surfaces.h"
#include "acus/scene/effects/view_3d/view_3d.h"

namespace acus::window {
namespace {

/// Coarse enough for a window that is drawn thirty times a second.
constexpr double kSurfaceGridMm = 3.0;
constexpr double kSkinOpacity = 0.3;

/// What the teaching view shows if the scenario does not say it; the skin last, as it is drawn.
std::vector<effects::View3dSettings::Surface> StandardSurfaces() {
  std::vector<effects::View3dSettings::Surface> surfaces;
  for (const char* tissue : {"bone", "kidney", "vessel", "lesion", "spinal_canal"}) {
    surfaces.push_back({.tissue = tissue, .opacity = 1.0, .colour = std::nullopt});
  }
  surfaces.push_back({.tissue = "liver", .opacity = 0.55, .colour = std::nullopt});
  surfaces.push_back({.tissue = "skin", .opacity = kSkinOpacity, .colour = std::nullopt});
  return surfaces;
}

effects::View3dSettings ViewOf(const scenario::Scenario& scenario) {
  effects::View3dSettings view;
  for (const effects::CalledEffect& called : scenario.listed) {
    if (called.effect == &effects::View3d()) view = effects::ReadView3dSettings(called.settings);
  }
  if (view.surfaces.empty()) view.surfaces = StandardSurfaces();
  if (view.layers.empty()) view.layers = {{.preset = "bone", .opacity = 1.0}};
  view.surface_grid_mm = std::max(view.surface_grid_mm, kSurfaceGridMm);
  // Transparent ones over what they hide.
  std::ranges::stable_partition(view.surfaces,
                                [](const auto& surface) { return surface.tissue != "skin"; });
  return view;
}

}  // namespace

PatientOnDisplay PatientOnDisplayOf(const scenario::Scenario& scenario,
                                    const simulation::Scene& scene, const RunContext& context) {
  PatientOnDisplay patient;
  const effects::View3dSettings view = ViewOf(scenario);
  auto labels = scene.labels;
  if (!labels && !scenario.patient.labels.empty()) {
    labels = std::make_shared<volume::LabelMap>(volume::ReadTissues(scenario.patient.labels));
  }
  if (labels) patient.in_teaching_view = effects::SurfacesOf(view, *labels, context);
  auto ct = scene.ct;
  if (!ct && !scenario.patient.ct.empty()) {
    ct = std::make_shared<volume::CtVolume>(
        volume::ReadCt(scenario.patient.ct, scenario.patient.dicom_series, context));
  }
  if (ct) {
    patient.in_overlay.ct = ct;
    for (const auto& layer : view.layers) {
      patient.in_overlay.layers.push_back({layer.preset, layer.opacity});
    }
  }
  if (scene.breathing && scene.breathing->image) {
    patient.in_overlay.field = &scene.breathing->motion.model.field();
  }
  return patient;
}

}  // namespace acus::window
