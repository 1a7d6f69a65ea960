// Plays the sound of the effect pain_reaction in a session.
#pragma once

#include <atomic>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acus/data/sound/loudspeaker.h"
#include "acus/data/sound/sound.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

class PatientVoice {
 public:
  /// Opens the loudspeaker. Without one, the session runs, and trouble() gives the reason.
  /// @param scene  Must outlive this. @param sound  As replay::PainSoundOf() gives it.
  PatientVoice(const simulation::Scene& scene, const sound::Sound& sound);

  /// Plays if there is a new reaction. One thread, not that of the steps.
  void Follow(const LiveSnapshot& snapshot) noexcept;

  /// The problem, for the user; empty if there is none.
  const std::string& trouble() const { return trouble_; }
  nlohmann::json ToJson() const;

 private:
  const simulation::Scene& scene_;
  std::unique_ptr<loudspeaker::Loudspeaker> loudspeaker_;
  std::string trouble_;
  int reactions_ = 0;
  std::atomic<int> played_{0};
};

}  // namespace acus::live
