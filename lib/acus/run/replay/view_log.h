// The view in three dimensions of a replay: film and pictures.
#pragma once

#include <filesystem>
#include <vector>

#include "acus/run/replay/image_log.h"

namespace acus::replay {

/// Renders every so many of `snapshots`, for the view's rate, and writes view_3d.mp4 and
/// view_3d.png (of the middle of the session; with PngChoice::kAll, all into frames/) into
/// `folder`, or nothing if it is empty or the plan has no such view. The bytes do not depend on
/// context.num_threads. Adds the cost to `times`, if given.
ImageLog RenderView(const simulation::Scene& scene,
                    const std::vector<simulation::Snapshot>& snapshots,
                    const std::filesystem::path& folder, const ReplayOptions& options,
                    simulation::StageTimes* times, const RunContext& context);

}  // namespace acus::replay
