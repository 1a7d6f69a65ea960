// The options of `acus-tradeoff scene`, and what it does with them.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::tuning {

/// Adds the options to the subcommand; they write into what the result holds.
/// @returns runs what the command line asks for, and gives the text for the terminal.
std::function<std::string(RunContext& context)> AddSceneOptions(CLI::App& command);

}  // namespace acus::tuning
