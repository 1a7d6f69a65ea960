// The sound of a patient in pain (effect pain_reaction), in live sessions and replays.
#pragma once

#include <filesystem>
#include <optional>

#include "acus/base/core/run_context.h"
#include "acus/data/sound/sound.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

/// Starts at the pain: silence until the patient moves, then the sound. Nothing if the scenario has
/// no such effect, or it has no sound. @throws InputError if the file is no usable sound.
std::optional<sound::Sound> PainSoundOf(const scenario::Scenario& scenario, RunContext& context);

/// Number of reactions up to that step. 0 without the effect in the plan.
int ReactionsIn(const simulation::Scene& scene, const simulation::StepOutput& output);

/// Writes pain_reaction.wav, with the sound at each reaction; at least as long as the session.
void WritePainSound(const std::filesystem::path& folder, const sound::Sound& sound,
                    const simulation::Scene& scene, const StepLog& log);

}  // namespace acus::replay
