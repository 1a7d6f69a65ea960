// Requests for a scene on a label map.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"

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
  std::filesystem::path vertebrae = {};  ///< vertebrae.csv of acus-segment; for heights.

  bool empty() const { return target.empty() && window.empty(); }

  /// --target and --window.
  void AddOptions(CLI::App& app);

  /// If the target is a height of the spine: takes the vertebrae.csv beside the label map, which
  /// becomes an input of the provenance. @throws InputError if it does not have that height.
  void FindVertebrae(const std::filesystem::path& labels_file, RunContext& context);
};

}  // namespace acus::phantom
