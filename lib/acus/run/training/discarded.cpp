#include "acus/run/training/discarded.h"

#include "acus/base/core/error.h"

namespace acus::training {

namespace fs = std::filesystem;

bool IsDiscarded(const fs::path& folder) {
  return fs::exists(folder / kDiscardedFile) || fs::exists(folder / ".." / kDiscardedFile);
}

std::vector<fs::path> KeptRuns(std::span<const fs::path> runs, RunContext& context) {
  std::vector<fs::path> kept;
  for (const fs::path& run : runs) {
    if (IsDiscarded(run)) {
      context.Warn(Message(run.string(), ": the session was discarded (", kDiscardedFile,
                           "): it is not used"));
    } else {
      kept.push_back(run);
    }
  }
  ACUS_REQUIRE(!kept.empty(), runs.front().string(), ": the session was discarded (",
               kDiscardedFile, "), and no other is given; give sessions that count");
  return kept;
}

}  // namespace acus::training
