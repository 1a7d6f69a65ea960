// What a user should doubt in a replay.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "acus/run/replay/step_log.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/snapshot.h"

namespace acus::replay {

/// Samples that were no poses, tools that never met the body, and a needle that never came to rest.
/// @param images  Moments of the scene's images; may be empty.
std::vector<std::string> RunWarnings(const simulation::Scene& scene, const StepLog& log,
                                     std::span<const simulation::Snapshot> images);

}  // namespace acus::replay
