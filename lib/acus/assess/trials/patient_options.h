// The options for a scenario and its patient, as those of acus-replay.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/scene/scenario/scenario.h"

namespace CLI {
class App;
}

namespace acus::trials {

struct PatientOptions {
  std::filesystem::path scenario;
  std::filesystem::path ct;
  std::filesystem::path labels;
  std::filesystem::path transform;
  std::filesystem::path exercise;
  std::vector<std::string> changes;

  /// Adds the positional SCENARIO and the options to a subcommand; they write into this object,
  /// which must outlive it.
  void AddTo(CLI::App& command);

  /// @throws InputError as scenario::ReadScenario.
  scenario::Scenario Scenario(RunContext& context) const;
  /// Absolute, or among the presets. @throws InputError if it does not exist.
  std::filesystem::path ExerciseFile() const;
};

}  // namespace acus::trials
