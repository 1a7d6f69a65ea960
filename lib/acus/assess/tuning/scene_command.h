// The options of `acus-tradeoff scene`, and their execution.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::tuning {

/// Adds the options to the subcommand; the returned function holds their values.
/// @returns a function that runs the command, and returns the text for the terminal.
std::function<std::string(RunContext& context)> AddSceneOptions(CLI::App& command);

}  // namespace acus::tuning
