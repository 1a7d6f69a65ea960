// The images that effects of the list add to a replay.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/run/replay/image_log.h"

namespace acus::replay {

/// Adds to `moments` the times at which effects render their own images, over the whole session.
/// All are then in order of time.
void AddOwnMoments(const simulation::Scene& scene, const session::Session& session,
                   std::vector<simulation::Snapshot>& moments);

/// The snapshots of the scene's images.
std::vector<simulation::Snapshot> MomentsOfScene(const std::vector<simulation::Snapshot>& moments);

struct EffectImageLog {
  std::string key;  ///< Key of the effect.
  ImageLog log;
};

/// Renders the images of all effects and writes KEY.mp4, PNG files and, for images with a fixed
/// pose, KEY.igs.mha into `folder`, or nothing if that is empty. The bytes do not depend on
/// context.num_threads. Adds the cost of the stages to `times`, if given.
std::vector<EffectImageLog> RenderEffectImages(
    const simulation::Scene& scene, const std::vector<simulation::Snapshot>& moments,
    const StepLog& steps, const std::filesystem::path& folder, const ReplayOptions& options,
    simulation::StageTimes* times, const RunContext& context);

}  // namespace acus::replay
