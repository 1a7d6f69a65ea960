#include "acus/assess/trials/what_if_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/trials/patient_options.h"
#include "acus/assess/trials/what_if_files.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/session/session_import.h"

namespace acus::trials {
namespace {

namespace fs = std::filesystem;

struct WhatIfOptions {
  PatientOptions patient;
  fs::path session;
  fs::path ranges = "what_if/default.json";
  int count = 0;
  fs::path output;
};

std::string Run(const WhatIfOptions& options, RunContext& context) {
  const fs::path ranges = config::FindConfig(options.ranges, fs::current_path());
  WhatIfSettings settings = ReadWhatIfSettings(ranges);
  context.provenance.AddInput(ranges);
  if (options.count > 0) settings.count = options.count;
  std::optional<AtomicFolder> folder;
  if (!options.output.empty()) folder.emplace(options.output, context.overwrite);
  const scenario::Scenario scenario = options.patient.Scenario(context);
  const session::Session trial =
      session::ReadAnySession(options.session, scenario.session, context).session;
  context.provenance.AddInput(options.session);
  const TrialScene scene = LoadTrialScene(scenario, options.patient.ExerciseFile(), trial, context);
  ACUS_REQUIRE(!trial.needle.empty(), options.session.string(), ": has no needle");
  const WhatIf what_if = RunWhatIf(scene, trial, settings, context);
  std::string text = WhatIfText(scene, what_if, settings.best);
  if (folder) {
    WriteWhatIf(folder->path(), scene, trial, what_if, settings, context);
    folder->Commit();
    text += "Page: " + (options.output / "what_if.html").string() + "\n";
  }
  return text;
}

}  // namespace

std::function<std::string(RunContext& context)> AddWhatIfOptions(CLI::App& command) {
  const auto options = std::make_shared<WhatIfOptions>();
  options->patient.AddTo(command);
  command
      .add_option("session", options->session,
                  "The trial: a session folder, or another recording that acus-replay reads")
      ->required()
      ->check(CLI::ExistingPath);
  command
      .add_option("--ranges", options->ranges,
                  "How the insertion may differ (acus-what-if JSON): a file, or a preset")
      ->capture_default_str();
  command.add_option("--count", options->count, "Alternatives, in place of the file's")
      ->check(CLI::Range(1, 100000));
  command.add_option("-o,--output", options->output,
                     "Folder to make: what_if.html, what_if.csv, what_if.json, map.svg, sessions");
  return [options](RunContext& context) { return Run(*options, context); };
}

}  // namespace acus::trials
