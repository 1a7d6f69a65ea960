#include "acus/scene/simulation/fluoroscopy_renderer.h"

#include "acus/scene/simulation/breathing_scene.h"
#include "acus/scene/simulation/picture_sleep.h"

namespace acus::simulation {

FluoroscopyRenderer::FluoroscopyRenderer(const Scene& scene, int num_threads)
    : scene_(scene),
      fluoroscope_(*scene.ct, scene.fluoroscopy->c_arm, scene.fluoroscopy->pose, num_threads) {
  if (scene.tools_deform_images) {
    deformed_.emplace(*scene.tissue, scene.warp_spacing_mm, scene.inverse_iterations);
  }
}

void FluoroscopyRenderer::Render(const Snapshot& snapshot, image::GrayImage& out, int num_threads,
                                 StageTimes* times, const Snapshot* shown) {
  auto watch = Stopwatch::OfThreads(times, num_threads);
  const bool with_needle = scene_.fluoroscopy->needle;
  const bool still = shown != nullptr && TissueHasStayed(scene_, *shown, snapshot);
  const bool asleep = still && (!with_needle || NeedleHasStayed(*shown, snapshot));
  const slicing::RestMap* rest = nullptr;
  if (!still && deformed_ && snapshot.load != nullptr) {
    deformed_->Update(*snapshot.load);
    rest = &*deformed_;
  }
  std::optional<BreathingRest> breathing;
  if (!still && scene_.breathing && scene_.breathing->image) {
    breathing.emplace(*scene_.breathing, snapshot.session_s, snapshot.breath, rest);
    if (breathing->moves()) rest = &*breathing;
  }
  if (scene_.plan.Reads(StageId::kFluoroscopy, "rest map")) {
    const Sleep idle = still ? Sleep::kNothingMoved : Sleep::kUndeformed;
    watch.EndOf(StageId::kDeformation, rest != nullptr ? Sleep::kAwake : idle);
  }
  if (!asleep) {
    const auto needle = with_needle ? NeedleInPicture(scene_, snapshot) : std::nullopt;
    if (still) {
      fluoroscope_.RenderNeedle(needle, out);
    } else {
      fluoroscope_.Render(needle, out, num_threads, rest);
    }
  }
  watch.EndOf(StageId::kFluoroscopy, asleep ? Sleep::kNothingMoved : Sleep::kAwake);
}

}  // namespace acus::simulation
