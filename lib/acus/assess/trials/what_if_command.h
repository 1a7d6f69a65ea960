// The subcommand what-if of acus-training.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::trials {

/// Adds the options to the subcommand; the returned function holds their values.
/// @returns a function that runs the command, and returns the text for the terminal.
std::function<std::string(RunContext& context)> AddWhatIfOptions(CLI::App& command);

}  // namespace acus::trials
