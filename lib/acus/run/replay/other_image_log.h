// The images that effects of the list add to a replay.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/run/replay/image_log.h"

namespace acus::replay {

/// A film in the run folder.
struct WrittenFilm {
  std::string file;
  std::string title;
};

struct OtherImageLog {
  std::vector<WrittenPng> pngs;
  std::vector<WrittenFilm> films;
};

/// Renders them at the moments of the probe's images and writes KEY.mp4 and PNG files into
/// `folder`, or nothing if that is empty. Adds the cost of the stages to `times`, if given.
OtherImageLog RenderOtherImages(const simulation::Scene& scene,
                                const std::vector<simulation::Snapshot>& snapshots,
                                const std::filesystem::path& folder, const ReplayOptions& options,
                                simulation::StageTimes* times, const RunContext& context);

}  // namespace acus::replay
