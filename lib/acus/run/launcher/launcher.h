// The window that starts sessions: patients, exercises, devices and progress.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::launcher {

struct LauncherSettings {
  std::filesystem::path folder;        ///< Of workplaces.
  std::filesystem::path live_session;  ///< pipelines/live-session.
  /// Given to each session besides: --headless, --duration.
  std::vector<std::string> session_options;
};

/// Adds the options of acus-launcher; the returned function runs it until its window is closed.
std::function<ExitCode(RunContext& context, std::ostream& out)> AddLauncherOptions(CLI::App& app);

}  // namespace acus::launcher
