// The command line of acus-live.
#pragma once

#include <functional>
#include <iosfwd>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::window {

/// Adds the options to `app`. What comes back runs the session, or the sessions, that they ask for.
/// What they print goes to `out`.
std::function<ExitCode(RunContext& context, std::ostream& out)> AddLiveOptions(CLI::App& app);

}  // namespace acus::window
