// What is heard of a patient in pain (effect pain_reaction), live and in a replay.
#pragma once

#include <filesystem>
#include <optional>

#include "acus/base/core/run_context.h"
#include "acus/data/sound/sound.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

/// Begins with the pain: there is silence until the patient moves. Nothing if the scenario has no
/// such effect, or it has no sound. @throws InputError if the file is no sound that can be used.
std::optional<sound::Sound> PainSoundOf(const scenario::Scenario& scenario, RunContext& context);

/// Reactions so far, in that step. 0 without the effect in the plan.
int ReactionsIn(const simulation::Scene& scene, const simulation::StepOutput& output);

/// pain_reaction.wav, with the sound at each reaction; as long as the session, at least.
void WritePainSound(const std::filesystem::path& folder, const sound::Sound& sound,
                    const simulation::Scene& scene, const StepLog& log);

}  // namespace acus::replay
