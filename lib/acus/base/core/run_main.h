// The one frame around every program: standard options, progress, errors to exit codes.
#pragma once

#include <functional>

#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus {

/// Adds --version, --threads, --seed, --quiet and --overwrite to `app`, parses, calls `body` and
/// turns its result or exception into the exit code. The only catch-all of the project.
///
/// Messages and the progress bar go to stderr; stdout is the body's. Ctrl-C, SIGTERM and the
/// end of the terminal (SIGHUP, unless it is ignored) stop the body at its next Checkpoint; outputs
/// not yet committed are removed.
int RunMain(CLI::App& app, int argc, const char* const* argv,
            const std::function<ExitCode(RunContext&)>& body);

}  // namespace acus
