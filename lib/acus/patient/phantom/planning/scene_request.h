// Requests for a scene on a label map.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/planning/spinal_level.h"

namespace CLI {
class App;
}

namespace acus::phantom {

/// Empty: the program chooses.
struct SceneRequest {
  /// A structure such as "liver" or "kidney_left", "x,y,z" (CT LPS, mm), or the canal at a height
  /// of the spine such as "L3-L4".
  std::string target = {};
  std::string window = {};               ///< A name of WindowNames().
  std::filesystem::path vertebrae = {};  ///< vertebrae.csv of acus-segment, or empty; for heights.

  /// The levels of `vertebrae`; none without it.
  std::vector<NamedLevel> Levels() const;

  bool empty() const { return target.empty() && window.empty(); }

  /// --target and --window.
  void AddOptions(CLI::App& app);

  /// Takes the vertebrae.csv beside the label map, if there is one; it becomes an input of the
  /// provenance. @throws InputError if the target is a height of the spine that it does not have.
  void FindVertebrae(const std::filesystem::path& labels_file, RunContext& context);
};

}  // namespace acus::phantom
