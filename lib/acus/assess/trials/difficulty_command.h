// acus-training difficulty: a table of cases for a curriculum.
#pragma once

#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::trials {

/// Adds the options to the subcommand. The returned function runs it and returns the text to print.
std::function<std::string(RunContext& context)> AddDifficultyOptions(CLI::App& command);

}  // namespace acus::trials
