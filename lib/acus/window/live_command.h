// The command line of acus-live.
#pragma once

#include <functional>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::window {

/// Adds the options to `app`. What comes back runs the session, or the sessions, that they ask for.
std::function<ExitCode(RunContext& context)> AddLiveOptions(CLI::App& app);

}  // namespace acus::window
