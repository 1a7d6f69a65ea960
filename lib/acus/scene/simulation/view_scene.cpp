#include "acus/scene/simulation/view_scene.h"

#include <algorithm>
#include <set>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/surface_extraction.h"
#include "acus/scene/simulation/picture_sleep.h"

namespace acus::simulation {
namespace {

/// The outer border of all that is labelled.
constexpr std::string_view kSkin = "skin";
constexpr double kLeastPartMl = 0.1;

segmentation::Mask MaskOf(const volume::LabelMap& labels, std::string_view tissue) {
  const volume::Label wanted = volume::LabelOf(tissue);
  segmentation::Mask mask(labels.geometry);
  std::ranges::transform(labels.voxels, mask.voxels.begin(), [&](volume::Label label) {
    return static_cast<std::uint8_t>(tissue == kSkin ? label != 0 : label == wanted);
  });
  return mask;
}

Eigen::Array3f StandardColour(std::string_view tissue) {
  const auto rgb = volume::ColourOf(volume::LabelOf(tissue));
  return Eigen::Array3f(rgb[0], rgb[1], rgb[2]) / 255.0F;
}

volume_rendering::PatientInView PatientOf(const Scene& scene, const RunContext& context) {
  const scenario::View3dEffect& effect = *scene.view_3d;
  volume_rendering::PatientInView patient;
  if (!effect.layers.empty()) patient.ct = scene.ct;
  for (const auto& layer : effect.layers) patient.layers.push_back({layer.preset, layer.opacity});
  if (!effect.surfaces.empty()) patient.surfaces = SurfacesOf(effect, *scene.labels, context);
  if (scene.breathing && scene.breathing->image) {
    patient.field = &scene.breathing->motion.model.field();
  }
  return patient;
}

volume_rendering::ViewSettings SettingsOf(const scenario::View3dEffect& effect) {
  volume_rendering::ViewSettings settings;
  settings.rays.step_mm = effect.step_mm;
  settings.rays.warp.max_iterations = effect.inverse_iterations;
  settings.rays.warp.lattice_mm = effect.warp_tolerance_mm;
  settings.rays.tool_shine = effect.tool_shine;
  settings.supersampling = effect.supersampling;
  settings.tool_shadows = effect.shadows;
  return settings;
}

volume_rendering::Camera CameraOf(const scenario::View3dEffect& effect,
                                  const Eigen::AlignedBox3d& box) {
  const volume_rendering::PictureSize size{effect.width_px, effect.height_px};
  if (!effect.eye_in_ct_mm) {
    return LookAt(volume_rendering::ViewFrom(effect.from, box, size, effect.view_angle_deg), size);
  }
  return LookAt({.eye_in_ct_mm = *effect.eye_in_ct_mm,
                 .focus_in_ct_mm = *effect.focus_in_ct_mm,
                 .up_in_ct = effect.up_in_ct,
                 .view_angle_deg = effect.view_angle_deg},
                size);
}

}  // namespace

std::vector<volume_rendering::SurfaceInView> SurfacesOf(const scenario::View3dEffect& effect,
                                                        const volume::LabelMap& labels,
                                                        const RunContext& context) {
  std::vector<volume_rendering::SurfaceInView> out;
  for (const auto& surface : effect.surfaces) {
    const segmentation::Mask mask = MaskOf(labels, surface.tissue);
    const double ml =
        1e-3 * static_cast<double>(segmentation::Count(mask)) * labels.geometry.voxel_volume_mm3();
    if (ml < kLeastPartMl) continue;
    context.Checkpoint("surfaces of the view", 0.0);
    segmentation::SurfaceOptions options;
    options.grid_mm = effect.surface_grid_mm;
    options.min_part_ml = kLeastPartMl;
    volume_rendering::SurfaceInView seen;
    seen.name = surface.tissue;
    seen.opacity = surface.opacity;
    seen.colour = surface.colour ? *surface.colour : StandardColour(surface.tissue);
    seen.surface = segmentation::ExtractSurface(mask, options, context.num_threads);
    out.push_back(std::move(seen));
  }
  ACUS_REQUIRE(!out.empty() || !effect.layers.empty(),
               "view_3d: the label map has none of the tissues that are to be shown");
  return out;
}

ViewRenderer::ViewRenderer(const Scene& scene, const RunContext& context)
    : scene_(scene),
      view_(PatientOf(scene, context), SettingsOf(*scene.view_3d)),
      camera_(CameraOf(*scene.view_3d, view_.box_in_ct_mm())) {}

bool ViewRenderer::HasStayed(const Snapshot& before, const Snapshot& now) const noexcept {
  return (!scene_.view_3d->needle || NeedleHasStayed(before, now)) &&
         (!scene_.view_3d->probe || ProbeHasStayed(before, now)) &&
         BreathHasStayed(scene_, before, now);
}

void ViewRenderer::Render(const Snapshot& snapshot, const image::GrayImage* b_mode,
                          volume_rendering::ViewPicture& out, int num_threads, StageTimes* times,
                          const Snapshot* shown) {
  auto watch = Stopwatch::OfThreads(times, num_threads);
  if (shown != nullptr && HasStayed(*shown, snapshot)) {
    watch.EndOf(StageId::kView3d, Sleep::kNothingMoved);
    return;
  }
  const scenario::View3dEffect& effect = *scene_.view_3d;
  volume_rendering::ViewMoment moment;
  std::optional<breathing::MotionMap> motion;
  if (scene_.breathing && scene_.breathing->image) {
    motion.emplace(scene_.breathing->At(snapshot.session_s, snapshot.breath));
    moment.motion = &*motion;
  }
  if (effect.needle) moment.needle = NeedleInPicture(scene_, snapshot);
  if (effect.probe && snapshot.probe_valid) {
    moment.probe.emplace();
    moment.probe->ct_from_probe = snapshot.ct_from_probe;
    moment.probe->probe = &*scene_.probe;
    if (b_mode != nullptr && !b_mode->pixels.empty()) moment.probe->b_mode = b_mode;
  }
  view_.Render(camera_, moment, out, num_threads);
  watch.EndOf(StageId::kView3d);
}

}  // namespace acus::simulation
