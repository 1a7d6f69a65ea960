// The list of effects that a scenario may name.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "acus/scene/effects/effect.h"

namespace acus::effects {

/// An effect that a scenario names.
struct CalledEffect {
  const Effect* effect = nullptr;
  nlohmann::json settings;  ///< As the schema checked and completed them; paths are absolute.

  std::optional<StageDeclaration> step() const { return effect->StepStageOf(settings); }
  std::optional<StageDeclaration> image() const { return effect->ImageStageOf(settings); }
  ImageTiming timing() const { return effect->TimingOf(settings); }
  /// True if its stage at every sample writes the port.
  bool StepWrites(PortRef port) const;
};

/// All effects: those of Acus, then those that were registered, in that order.
std::vector<const Effect*> AllEffects();

/// Adds an effect for the rest of the process. Not while another thread reads a scenario.
/// @param effect  Of static storage.
/// @throws InputError if there is an effect of that key, or the key is no plain word.
void RegisterEffect(const Effect& effect);

/// The schema of scenarios with the parts of all effects. `base` has the object of effects at
/// /properties/effects/properties.
nlohmann::json WithEffects(nlohmann::json base);

}  // namespace acus::effects
