// The outputs of every stage in every step and image, to find where two replays differ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/run/replay/step_log.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::replay {

/// Writes trace.csv: one row per step; columns time_s, then STAGE/VARIABLE for the stages in the
/// plan, in the order in which they run. Numbers are the shortest text that reads back as the same
/// double.
void WriteTrace(const std::filesystem::path& path, const StepLog& log,
                const simulation::Scene& scene);

/// Collects image_trace.csv: one row per image; columns time_s, then STAGE/sha256 of its pixels.
class ImageTrace {
 public:
  void Add(std::int64_t time_ns, const simulation::ProbeImages& images);
  void Write(const std::filesystem::path& path) const;

 private:
  std::string rows_;
};

}  // namespace acus::replay
