// The subcommand of acus-phantom that puts ducts into a liver.
#pragma once

#include <iosfwd>
#include <memory>

#include "acus/base/core/error.h"
#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::phantom {

/// What the command line calls for; see AddDuctsTask.
class DuctsTask {
 public:
  struct Options;
  explicit DuctsTask(std::shared_ptr<Options> options) : options_(std::move(options)) {}

  bool IsChosen() const;
  /// Reads CT and labels, writes the folder, and says on `out` what was put in.
  /// @throws InputError, NoAnswerError as PutDuctsIntoLiver.
  ExitCode Run(std::ostream& out, RunContext& context) const;

 private:
  std::shared_ptr<Options> options_;
};

/// Adds the subcommand ducts.
DuctsTask AddDuctsTask(CLI::App& app);

}  // namespace acus::phantom
