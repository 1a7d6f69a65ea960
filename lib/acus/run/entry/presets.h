// The presets of an installation, by kind: files that a scenario, an option or a file can name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace acus::entry {

struct Preset {
  std::string name;     ///< In the form that programs accept: "needles/spinal_22g.json".
  std::string summary;  ///< One line; empty if the file has no name, description or comment.
};

/// Folders of presets, sorted: "needles", "probes", ... Schemas are excluded.
/// @throws InputError if there is no folder of presets.
std::vector<std::string> PresetKinds(const std::filesystem::path& configs);

/// The presets of a kind, sorted by name. The summary is the file's "description" or "name", or
/// else the first sentence of its first comment. A file that is no valid JSON is listed without
/// one.
/// @throws InputError naming all kinds if there is none of that name.
std::vector<Preset> PresetsOf(const std::filesystem::path& configs, const std::string& kind);

}  // namespace acus::entry
