// A folder with scene.json and session/, and replays of it.
#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <vector>

#include "acus/run/replay/replay.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {

class ReplayFolder : public testing::Test {
 protected:
  /// @param run_folder  In the folder; null: nothing is written.
  replay::ReplayResult Run(const char* run_folder, int num_threads,
                           const std::vector<scenario::Override>& overrides = {}) {
    RunContext context;
    context.num_threads = num_threads;
    replay::ReplayOptions options;
    if (run_folder != nullptr) options.run_folder = folder_ / run_folder;
    return replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", overrides),
                                 folder_ / "session", options, context);
  }

  TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  RunContext context_;
};

}  // namespace acus::testing_support
