// A scenario as a document: read, changed, and rewritten for another folder.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus::scenario {

/// One change to a scenario from the command line: JSON pointer and value.
struct Override {
  std::string pointer;  ///< "/effects/ultrasound/needle"
  nlohmann::json value;
};

/// Parses "/pointer=value". The value is JSON, or else a string, as are numbers where a scenario
/// has a text (a part of a series UID); "null" removes the key, which switches an effect off.
/// @throws InputError if there is no '=' or no leading '/'.
Override ParseOverride(const std::string& text);

/// The file with changes applied, as it stands: not checked, defaults not filled in. Of changes,
/// paths of patient, session and breathing are relative to the working folder, and become absolute.
/// /patient/ct_from_reference_file may be "identity"; it takes the place of ct_from_reference, and
/// the other way round.
/// @throws InputError if it is no JSON, or has no such place as a change names.
nlohmann::json ScenarioDocument(const std::filesystem::path& path,
                                std::span<const Override> changes);

/// JSON pointers of paths that are relative to the scenario file.
std::vector<std::string> PathPointers();

/// JSON pointers of presets, which are also looked up in the installed configs.
std::vector<std::string> PresetPointers();

/// The document for another folder: paths that are found relative to `folder` become absolute.
/// Names of installed presets stay.
nlohmann::json ForAnyFolder(nlohmann::json document, const std::filesystem::path& folder);

/// A change for another folder: its paths and presets as above.
Override ForAnyFolder(Override change, const std::filesystem::path& folder);

}  // namespace acus::scenario
