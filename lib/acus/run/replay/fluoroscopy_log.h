// The fluoroscopy of a replay: pictures at their own rate, with a sequence and a film of their own.
#pragma once

#include <filesystem>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/replay.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/simulation/fluoroscopy_renderer.h"

namespace acus::replay {

/// The moments at which the C-arm looks: over the whole session, at its rate. Empty if the plan has
/// no fluoroscopy.
std::vector<simulation::Snapshot> FluoroscopySnapshots(const simulation::Scene& scene,
                                                       const session::Session& session);

/// Renders all snapshots and writes fluoroscopy.igs.mha, fluoroscopy.mp4 and PNG files into
/// `folder`, or nothing if `folder` is empty. The bytes do not depend on context.num_threads.
ImageLog RenderFluoroscopy(const simulation::Scene& scene,
                           const std::vector<simulation::Snapshot>& snapshots, const StepLog& steps,
                           const std::filesystem::path& folder, const ReplayOptions& options,
                           simulation::StageTimes* times, const RunContext& context);

}  // namespace acus::replay
