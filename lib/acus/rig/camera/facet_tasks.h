// The subcommands of acus-camera about facets: tracking them in images, and drawing such images.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::camera {

/// Files or names of presets.
struct FacetTaskFiles {
  std::filesystem::path board, facets, camera;
};

/// Runs the subcommand that was chosen, writes into an existing folder and returns a text for the
/// terminal; empty if none of them was.
using FacetTasks = std::function<std::string(
    const FacetTaskFiles& files, const std::filesystem::path& folder, RunContext& context)>;

/// Adds the subcommands track and sample.
FacetTasks AddFacetTasks(CLI::App& app);

}  // namespace acus::camera
