// The subcommands of acus-study.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::study {

/// Adds plan, report and export; the returned function holds their options.
/// @returns a function that runs the selected one, and returns the text for the terminal.
std::function<std::string(RunContext& context)> AddStudyCommands(CLI::App& app);

}  // namespace acus::study
