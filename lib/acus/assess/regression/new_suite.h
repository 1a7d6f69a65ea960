// Creates a suite from recorded sessions: the subcommand new of acus-regression.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::regression {

struct NewSuite {
  std::filesystem::path scenario = {};  ///< A file, or a preset.
  std::vector<std::filesystem::path> sessions = {};
  std::filesystem::path ct = {};      ///< Replaces the scenario's, as the next two; may be empty.
  std::filesystem::path labels = {};  ///< May be empty.
  std::filesystem::path transform = {};   ///< May be empty.
  std::vector<std::string> changes = {};  ///< "/pointer=value" for every case.
  std::string tolerances = "tolerances/default.json";
  std::string description = {};
};

/// Writes suite.json and provenance.json with one case for each session, named after its folder,
/// without expectations. Paths are relative to the folder of the suite.
/// @throws InputError if a session or the scenario cannot be replayed, a path does not exist, or
///     the folder has expectations already.
/// @returns a description of the suite, for the terminal.
std::string WriteNewSuite(const std::filesystem::path& folder, const NewSuite& suite,
                          RunContext& context);

/// Adds the options to the subcommand; the returned function holds their values.
/// @returns a function that makes the suite, and returns the text for the terminal.
std::function<std::string(RunContext& context)> AddNewSuiteOptions(CLI::App& command);

}  // namespace acus::regression
