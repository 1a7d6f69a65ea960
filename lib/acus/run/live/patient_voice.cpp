#include "acus/run/live/patient_voice.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/run/replay/pain_sound.h"

namespace acus::live {

PatientVoice::PatientVoice(const simulation::Scene& scene, const sound::Sound& sound)
    : scene_(scene) {
  try {
    loudspeaker_ = std::make_unique<loudspeaker::Loudspeaker>(sound);
  } catch (const InputError& error) {
    trouble_ = error.what();
  }
}

void PatientVoice::Follow(const LiveSnapshot& snapshot) noexcept {
  const int now = replay::ReactionsIn(scene_, snapshot.output);
  if (now > reactions_ && loudspeaker_) {
    loudspeaker_->Play();
    ++played_;
  }
  reactions_ = now;
}

nlohmann::json PatientVoice::ToJson() const {
  return {{"played", played_.load()}, {"trouble", trouble_}};
}

}  // namespace acus::live
