// The subcommands of acus-camera that place cameras: on a tracked body, and beside each other.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::camera {

/// Runs the subcommand that was chosen, writes into an existing folder and returns a text for the
/// terminal; empty if none of them was. `board` is a file or the name of a preset.
using RigTasks = std::function<std::string(
    const std::filesystem::path& board, const std::filesystem::path& folder, RunContext& context)>;

/// Adds the subcommands hand-eye and stereo.
RigTasks AddRigTasks(CLI::App& app);

}  // namespace acus::camera
