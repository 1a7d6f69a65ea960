#include "acus/scene/simulation/other_images.h"

namespace acus::simulation {

namespace ports = effects::ports;

OtherImageRenderer::OtherImageRenderer(const Scene& scene) : scene_(scene), rest_(scene) {
  for (const OtherEffect& other : scene.others.all()) {
    if (!other.has_image) continue;
    stages_.push_back({&other, other.loaded->NewImageStage()});
    ACUS_ASSERT(stages_.back().stage != nullptr);
    reads_images_ = reads_images_ || scene.plan.Reads(other.image_id, ports::kBMode) ||
                    scene.plan.Reads(other.image_id, ports::kCtImage);
  }
}

void OtherImageRenderer::Render(const Snapshot& snapshot, const Images& images,
                                std::vector<OtherImage>& out, StageTimes* times) {
  out.resize(stages_.size());
  if (stages_.empty()) return;
  Stopwatch watch(times);
  effects::PortValues values = scene_.others.data();
  values.Set(ports::kBMode, &images.b_mode);
  values.Set(ports::kCtImage, &images.ct_slice);
  values.Set(ports::kRestMap, rest_.At(snapshot));
  values.Set(ports::kProbe, &snapshot.ct_from_probe);
  effects::ImageMoment moment{.time_ns = snapshot.time_ns,
                              .session_s = snapshot.session_s,
                              .probe_valid = snapshot.probe_valid,
                              .ct_from_probe = snapshot.ct_from_probe,
                              .ct_from_needle = snapshot.ct_from_needle};
  for (std::size_t n = 0; n < stages_.size(); ++n) {
    const OtherEffect& effect = *stages_[n].effect;
    const bool has_state = effect.step != nullptr && snapshot.memory != nullptr;
    moment.state = has_state ? effect.StateIn(*snapshot.memory) : nullptr;
    out[n].key = effect.key;
    out[n].title = effect.title;
    const auto activity = stages_[n].stage->Render(moment, values, out[n].image);
    watch.EndOf(effect.image_id,
                activity == effects::Activity::kActive ? Sleep::kAwake : Sleep::kEffectIdle);
  }
}

}  // namespace acus::simulation
