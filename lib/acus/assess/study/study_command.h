// The subcommands of acus-study.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::study {

/// Adds plan, report and export; they write into what the result holds.
/// @returns runs the one that was given, and gives the text for the terminal.
std::function<std::string(RunContext& context)> AddStudyCommands(CLI::App& app);

}  // namespace acus::study
