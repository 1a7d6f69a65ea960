// The presets of an installation, by kind: what a scenario, an option or a file can name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace acus::entry {

struct Preset {
  std::string name;     ///< As it is given to programs: "needles/spinal_22g.json".
  std::string summary;  ///< One line; empty if the file has no name, description or comment.
};

/// Folders of presets, sorted: "needles", "probes", ... The schemas are none.
/// @throws InputError if there is no folder of presets.
std::vector<std::string> PresetKinds(const std::filesystem::path& configs);

/// Those of a kind, sorted by name. The summary is the file's "description" or "name", or else the
/// first sentence of its first comment. A file that cannot be read as JSON is listed without one.
/// @throws InputError naming all kinds if there is none of that name.
std::vector<Preset> PresetsOf(const std::filesystem::path& configs, const std::string& kind);

}  // namespace acus::entry
