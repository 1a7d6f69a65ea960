#include "acus/scene/simulation/moment_rest.h"

#include <algorithm>

namespace acus::simulation {

Eigen::Vector3d EffectsRest::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                        const Eigen::Vector3d& /*guess_in_ct_mm*/) const noexcept {
  const Eigen::Vector3d rest_mm = effects_.SeenRestInCtMm(memory_, place_in_ct_mm);
  return next_ == nullptr ? rest_mm : next_->RestInCtMm(rest_mm, rest_mm);
}

double EffectsRest::SpacingMm() const noexcept {
  const double spacing_mm = effects_.MotionSpacingMm();
  return next_ == nullptr ? spacing_mm : std::min(spacing_mm, next_->SpacingMm());
}

MomentRest::MomentRest(const Scene& scene, bool beyond_skin) : scene_(&scene) {
  if (scene.tools_deform_images) {
    deformed_.emplace(*scene.tissue, scene.warp_spacing_mm, scene.inverse_iterations, beyond_skin);
  }
  if (scene.pressed_by_probe) tissue_.emplace(*scene.labels);
}

const slicing::RestMap* MomentRest::At(const Snapshot& snapshot) {
  const slicing::RestMap* rest = nullptr;
  if (deformed_ && snapshot.load != nullptr) {
    deformed_->Update(*snapshot.load);
    rest = &*deformed_;
  }
  if (scene_->listed.shows_motion() && snapshot.memory != nullptr) {
    rest = &effects_.emplace(scene_->listed, *snapshot.memory, rest);
  }
  if (scene_->breathing && scene_->breathing->image) {
    breathing_.emplace(*scene_->breathing, snapshot.session_s, snapshot.breath, rest);
    if (breathing_->moves()) rest = &*breathing_;
  }
  if (tissue_ && snapshot.probe_valid) {
    const tissue::ProbeFace face{.length_mm = acoustics::FaceLengthMm(*scene_->probe),
                                 .radius_mm = acoustics::FaceRadiusMm(*scene_->probe)};
    pressed_.emplace(face, snapshot.ct_from_probe, *tissue_, rest, scene_->warp_spacing_mm);
    if (pressed_->presses()) rest = &*pressed_;
  }
  if (scene_->pressed_by_proxies && snapshot.probe_valid) {
    const forces::MultiProxyProbe& probe = *scene_->probe_force->multi_proxy();
    // As for the force: deeper along the beam.
    Eigen::Isometry3d ct_from_tool = snapshot.ct_from_probe;
    ct_from_tool.translation() += scene_->probe_press_mm * ct_from_tool.linear().col(1);
    palpated_.emplace(probe.tool(), ct_from_tool, *probe.fields().skin, probe.fields().skin_value,
                      rest, scene_->warp_spacing_mm);
    if (palpated_->presses()) rest = &*palpated_;
  }
  return rest;
}

}  // namespace acus::simulation
