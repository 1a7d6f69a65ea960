#include "acus/scene/simulation/effect_images.h"

#include "acus/scene/simulation/image_sleep.h"

namespace acus::simulation {
namespace {

namespace ports = effects::ports;
using effects::Activity;

Sleep SleepAfter(Activity activity) {
  if (activity == Activity::kUnchanged) return Sleep::kNothingMoved;
  return activity == Activity::kActive ? Sleep::kAwake : Sleep::kEffectIdle;
}

effects::ImageChanges ChangesSince(const Scene& scene, const Snapshot* shown, const Snapshot& now,
                                   bool images_changed) {
  if (shown == nullptr) return {};
  return {.needle = !NeedleHasStayed(*shown, now),
          .probe = !ProbeHasStayed(*shown, now),
          .breath = !BreathHasStayed(scene, *shown, now),
          .tissue = !TissueHasStayed(scene, *shown, now),
          .images = images_changed,
          .force = shown->needle_force_in_ct_n != now.needle_force_in_ct_n};
}

}  // namespace

EffectImageRenderer::EffectImageRenderer(const Scene& scene, const ListedEffect& effect,
                                         const RunContext& context)
    : scene_(scene),
      effect_(effect),
      num_threads_(context.num_threads),
      constant_(scene.listed.data()) {
  if (scene.needle) constant_.Set(ports::kNeedlePreset, &*scene.needle);
  if (scene.probe) constant_.Set(ports::kProbePreset, &*scene.probe);
  if (Reads(ports::kBreath)) {
    constant_.Set(ports::kMotionField, &scene.breathing->motion.model.field());
  }
  stage_ = effect.loaded->NewImageStage(constant_, context);
  ACUS_ASSERT(stage_ != nullptr);
  if (Reads(ports::kRestMap)) rest_.emplace(scene, /*beyond_skin=*/true);
  if (Reads(ports::kBMode) || Reads(ports::kCtImage)) {
    of_probe_.emplace(scene, nullptr,
                      Reads(ports::kCtImage) ? ImageChoice::kAll : ImageChoice::kBModeOnly,
                      Frames::kSingle);
  }
}

bool EffectImageRenderer::ImagesHaveChanged(const Snapshot& snapshot, const Snapshot* shown) const {
  if (shown == nullptr) return true;
  return (Reads(ports::kBMode) && !of_probe_->Sleeps(ports::kBMode, snapshot, *shown)) ||
         (Reads(ports::kCtImage) && !of_probe_->Sleeps(ports::kCtImage, snapshot, *shown));
}

void EffectImageRenderer::Render(const Snapshot& snapshot, const ProbeImages* images,
                                 effects::EffectPixels& out, StageTimes* times,
                                 const Snapshot* shown) {
  effects::PortValues values = constant_;
  bool images_changed = of_probe_.has_value();
  if (of_probe_) {
    if (images == nullptr) {
      of_probe_->Render(snapshot, images_, times, shown);
      images_changed = ImagesHaveChanged(snapshot, shown);
      images = &images_;
    }
    values.Set(ports::kBMode, &images->b_mode);
    values.Set(ports::kCtImage, &images->ct_slice);
  }
  auto watch = Stopwatch::OfThreads(times, num_threads_);
  effects::ImageMoment moment{.time_ns = snapshot.time_ns,
                              .session_s = snapshot.session_s,
                              .probe_valid = snapshot.probe_valid,
                              .ct_from_probe = snapshot.ct_from_probe,
                              .ct_from_needle = snapshot.ct_from_needle};
  moment.needle_force_in_ct_n = snapshot.needle_force_in_ct_n;
  moment.changes = ChangesSince(scene_, shown, snapshot, images_changed);
  if (rest_) {
    const bool needed = stage_->NeedsRestMap(moment.changes);
    const slicing::RestMap* rest = needed ? rest_->At(snapshot) : nullptr;
    values.Set(ports::kRestMap, rest);
    const Sleep idle = needed ? Sleep::kUndeformed : Sleep::kNothingMoved;
    watch.EndOf(scene_.plan.WriterOf(ports::kRestMap).number,
                rest != nullptr ? Sleep::kAwake : idle);
  }
  std::optional<image::NeedleInImage> needle;
  if (Reads(ports::kNeedlePreset)) needle = ImagedNeedle(scene_, snapshot);
  moment.needle = needle ? &*needle : nullptr;
  std::optional<breathing::MotionMap> breath;
  if (Reads(ports::kBreath)) {
    breath.emplace(scene_.breathing->At(snapshot.session_s, snapshot.breath));
    moment.breath = &*breath;
  }
  moment.tip_path_in_ct_mm = tip_path_in_ct_mm_;
  values.Set(ports::kProbe, &snapshot.ct_from_probe);
  const bool has_state = effect_.step != nullptr && snapshot.memory != nullptr;
  moment.state = has_state ? effect_.StateIn(*snapshot.memory) : nullptr;
  watch.EndOf(effect_.image_stage, SleepAfter(stage_->Render(moment, values, out)));
}

}  // namespace acus::simulation
