#include "acus/assess/trials/patient_options.h"

#include <CLI/CLI.hpp>

#include "acus/base/config/json_file.h"

namespace acus::trials {

namespace fs = std::filesystem;

void PatientOptions::AddTo(CLI::App& command) {
  command
      .add_option("scenario", scenario,
                  "Scenario (acus-scenario JSON): a file, or a preset such as\n"
                  "scenarios/lumbar_puncture.json")
      ->required();
  command
      .add_option("--exercise", exercise,
                  "Goals (acus-exercise JSON): a file, or a preset such as\n"
                  "exercises/lumbar_puncture.json")
      ->required();
  command.add_option("--ct", ct, "The patient's CT, in place of the scenario's")
      ->check(CLI::ExistingPath);
  command.add_option("--labels", labels, "The patient's label map, in place of the scenario's")
      ->check(CLI::ExistingFile);
  command
      .add_option("--transform", transform,
                  "ct_from_reference.tfm of acus-register in place of the scenario's, or identity")
      ->check(CLI::ExistingFile | CLI::IsMember({"identity"}));
  command.add_option("--set", changes,
                     "Change one value of the scenario: /json/pointer=value; =null takes it out");
}

scenario::Scenario PatientOptions::Scenario(RunContext& context) const {
  std::vector<scenario::Override> overrides;
  for (const std::string& change : changes) overrides.push_back(scenario::ParseOverride(change));
  const auto set_path = [&overrides](const char* pointer, const fs::path& path) {
    if (!path.empty()) overrides.push_back({pointer, path.string()});
  };
  set_path("/patient/ct", ct);
  set_path("/patient/labels", labels);
  set_path("/patient/ct_from_reference_file", transform);
  const fs::path file = config::FindConfig(scenario, fs::current_path());
  context.provenance.AddInput(file);
  return scenario::ReadScenario(file, overrides);
}

fs::path PatientOptions::ExerciseFile() const {
  return config::FindConfig(exercise, fs::current_path());
}

}  // namespace acus::trials
