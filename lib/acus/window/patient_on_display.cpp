#include "acus/window/patient_on_display.h"

#include <algorithm>
#include <utility>

#include "acus/base/translation/translation.h"
#include "acus/data/volume/volume_io.h"
#include "acus/scene/effects/view_3d/patient_surfaces.h"
#include "acus/scene/effects/view_3d/view_3d.h"
#include "acus/window/space_layer.h"

namespace acus::window {
namespace {

/// Coarse enough for a window that is rendered thirty times a second.
constexpr double kSurfaceGridMm = 3.0;
constexpr double kSkinOpacity = 0.3;
/// Total of all surfaces in the volume view: they move with the breath in each image.
constexpr int kVolumeTriangles = 40000;

/// The default content of the teaching view; the skin last, as it is drawn.
std::vector<effects::View3dSettings::Surface> StandardSurfaces() {
  std::vector<effects::View3dSettings::Surface> surfaces;
  for (const char* tissue : {"bone", "disc", "kidney", "vessel", "lesion", "spinal_canal", "tendon",
                             "cartilage", "bursa", "ligament", "gallbladder", "gland"}) {
    surfaces.push_back({.tissue = tissue, .opacity = 1.0, .colour = std::nullopt});
  }
  // Large organs, with others in them or behind them.
  for (const auto& [tissue, opacity] : {std::pair{"heart", 0.6},
                                        {"spleen", 0.6},
                                        {"pancreas", 0.7},
                                        {"liver", 0.55},
                                        {"stomach", 0.4},
                                        {"bowel", 0.4},
                                        {"bladder", 0.5},
                                        {"lung", 0.2},
                                        {"muscle", 0.15}}) {
    surfaces.push_back({.tissue = tissue, .opacity = opacity, .colour = std::nullopt});
  }
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
  // Transparent surfaces after those that they hide.
  std::ranges::stable_partition(view.surfaces,
                                [](const auto& surface) { return surface.tissue != "skin"; });
  return view;
}

using volume_rendering::PatientInView;

/// Bone by ray casting instead of triangles, with the other tissues around it.
PatientInView BoneAndOrgans(const PatientOnDisplay& patient) {
  PatientInView look = patient.in_overlay;
  for (const auto& surface : patient.in_teaching_view) {
    if (surface.name != "bone") look.surfaces.push_back(surface);
  }
  double all = 1.0;
  for (const auto& seen : look.surfaces) all += static_cast<double>(seen.surface.triangles.cols());
  const double share = std::min(1.0, kVolumeTriangles / all);
  for (auto& seen : look.surfaces) {
    seen.surface = Thinned(
        seen.surface, static_cast<int>(share * static_cast<double>(seen.surface.triangles.cols())));
  }
  return look;
}

/// The look of the scenario first, then the CT by each preset alone.
std::vector<VolumeLook> LooksOf(const PatientOnDisplay& patient) {
  std::vector<VolumeLook> looks;
  if (!patient.in_overlay.ct) return looks;
  using translation::Marked;
  looks.push_back({Marked("bone and organs"), BoneAndOrgans(patient)});
  for (const auto& [preset, name] : {std::pair{"skin", Marked("skin")},
                                     {"bone", Marked("bone")},
                                     {"soft_tissue", Marked("soft tissue")},
                                     {"vessels", Marked("vessels")}}) {
    PatientInView look = patient.in_overlay;
    look.layers = {{preset, 1.0}};
    looks.push_back({name, std::move(look)});
  }
  return looks;
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
    patient.in_overlay.labels = labels;
    for (const auto& layer : view.layers) {
      patient.in_overlay.layers.push_back({layer.preset, layer.opacity});
    }
  }
  if (scene.breathing && scene.breathing->image) {
    patient.in_overlay.field = &scene.breathing->motion.model.field();
  }
  patient.in_volume_view = LooksOf(patient);
  return patient;
}

}  // namespace acus::window
