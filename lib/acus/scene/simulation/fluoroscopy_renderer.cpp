#include "acus/scene/simulation/fluoroscopy_renderer.h"

#include "acus/scene/simulation/picture_sleep.h"

namespace acus::simulation {

FluoroscopyRenderer::FluoroscopyRenderer(const Scene& scene, int num_threads)
    : scene_(scene),
      rest_(scene),
      fluoroscope_(*scene.ct, scene.fluoroscopy->c_arm, scene.fluoroscopy->pose, num_threads) {}

void FluoroscopyRenderer::Render(const Snapshot& snapshot, image::GrayImage& out, int num_threads,
                                 StageTimes* times, const Snapshot* shown) {
  auto watch = Stopwatch::OfThreads(times, num_threads);
  const bool with_needle = scene_.fluoroscopy->needle;
  const bool still = shown != nullptr && TissueHasStayed(scene_, *shown, snapshot);
  const bool asleep = still && (!with_needle || NeedleHasStayed(*shown, snapshot));
  const slicing::RestMap* rest = still ? nullptr : rest_.At(snapshot);
  if (scene_.plan.Reads(StageId::kFluoroscopy, effects::ports::kRestMap)) {
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
