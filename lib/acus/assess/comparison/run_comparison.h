// Two run folders to one verdict.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/assess/comparison/check.h"
#include "acus/assess/comparison/compare_forces.h"
#include "acus/assess/comparison/compare_images.h"
#include "acus/assess/comparison/tolerances.h"
#include "acus/base/core/run_context.h"

namespace acus::comparison {

struct RunComparison {
  std::filesystem::path run_a;
  std::filesystem::path run_b;
  std::vector<Check> checks;
  ForceComparison forces;  ///< Its checks are also in `checks`, as are those of the images.
  ImageComparison images;

  bool passed() const;
  std::vector<std::string> failed() const;  ///< Quantities of the checks that failed.
};

/// Compares forces.csv, images.igs.mha and metrics.json of two folders written by acus-replay. What
/// neither has is left out; what only one has is a failed check.
/// @throws InputError if a folder has none of the three, or a file is broken.
RunComparison CompareRuns(const std::filesystem::path& run_a, const std::filesystem::path& run_b,
                          const Tolerances& tolerances, const RunContext& context);

/// For the terminal: one line per check, then the verdict.
std::string TableText(const RunComparison& comparison);

/// Of format acus-comparison/1, without provenance. A value that does not exist is null.
nlohmann::json ToJson(const RunComparison& comparison);

/// Writes comparison.json, comparison.html, provenance.json and, if there were images to compare,
/// worst_frame.png into an existing folder.
void WriteComparison(const std::filesystem::path& folder, const RunComparison& comparison,
                     const RunContext& context);

}  // namespace acus::comparison
