#include "simulation/fluoroscopy_renderer.h"

#include "simulation/breathing_scene.h"

namespace acus::simulation {

FluoroscopyRenderer::FluoroscopyRenderer(const Scene& scene, int num_threads)
    : scene_(scene),
      fluoroscope_(*scene.ct, scene.fluoroscopy->c_arm, scene.fluoroscopy->pose, num_threads) {
  if (scene.tools_deform_images) {
    deformed_.emplace(*scene.tissue, scene.warp_spacing_mm);
  }
}

void FluoroscopyRenderer::Render(const Snapshot& snapshot, ultrasound::GrayImage& out,
                                 int num_threads, StageTimes* times) {
  Stopwatch watch(times);
  const ultrasound::RestMap* rest = nullptr;
  if (deformed_ && snapshot.load != nullptr) {
    deformed_->Update(*snapshot.load);
    rest = &*deformed_;
  }
  std::optional<BreathingRest> breathing;
  if (scene_.breathing && scene_.breathing->image) {
    breathing.emplace(*scene_.breathing, snapshot.session_s, snapshot.breath, rest);
    if (breathing->moves()) rest = &*breathing;
  }
  fluoroscope_.Render(scene_.fluoroscopy->needle ? NeedleInPicture(scene_, snapshot) : std::nullopt,
                      out, num_threads, rest);
  watch.EndOf(StageId::kFluoroscopy);
}

}  // namespace acus::simulation
