// The command line of acus-live.
#pragma once

#include <functional>
#include <iosfwd>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::window {

/// Adds the options to `app`. The returned function runs the sessions that they request. Their
/// output goes to `out`.
std::function<ExitCode(RunContext& context, std::ostream& out)> AddLiveOptions(CLI::App& app);

}  // namespace acus::window
