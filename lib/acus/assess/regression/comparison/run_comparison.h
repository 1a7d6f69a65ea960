// Comparison of two run folders, with one verdict.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/assess/regression/comparison/check.h"
#include "acus/assess/regression/comparison/compare_forces.h"
#include "acus/assess/regression/comparison/compare_images.h"
#include "acus/assess/regression/comparison/tolerances.h"
#include "acus/base/core/run_context.h"

namespace acus::comparison {

struct RunComparison {
  std::filesystem::path run_a;
  std::filesystem::path run_b;
  std::vector<Check> checks;
  /// Files, columns and metrics of only one run, if that is no failure.
  std::vector<Check> only_in_one;
  ForceComparison forces;  ///< Its checks are also in `checks`, as are those of the images.
  ImageComparison images;

  bool passed() const;
  std::vector<std::string> failed() const;  ///< Quantities of the failed checks.
};

/// The consequence if only one run has a file, a column of a table, or a metric.
enum class Lack {
  kIsStated,  ///< It is listed, and no failure: a session beside its replay has no images.
  kFails
};

/// Names of the files in a folder that can be compared: forces.csv, probe_forces.csv, other tables
/// over time that effects write, images.igs.mha, metrics.json. A session of acus-live has those
/// that it recorded; recordings of devices and trackers are excluded.
std::vector<std::string> ComparableFiles(const std::filesystem::path& run);

/// Compares the common files of both folders, written by acus-replay or acus-live.
/// @throws InputError if a folder has no file to compare, or the two have no file in common, or a
///     file is broken.
RunComparison CompareRuns(const std::filesystem::path& run_a, const std::filesystem::path& run_b,
                          const Tolerances& tolerances, Lack lack, const RunContext& context);

/// For the terminal: one line per check, then the verdict.
std::string TableText(const RunComparison& comparison);

/// Format acus-comparison/1, without provenance. A missing value is null.
nlohmann::json ToJson(const RunComparison& comparison);

/// Writes comparison.json, comparison.html, provenance.json and, if there were images to compare,
/// worst_frame.png into an existing folder.
void WriteComparison(const std::filesystem::path& folder, const RunComparison& comparison,
                     const RunContext& context);

}  // namespace acus::comparison
