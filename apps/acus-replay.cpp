// acus-replay: a recorded session through the force and ultrasound models of a scenario.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/run/replay/replay.h"

int main(int argc, char** argv) {
  std::filesystem::path scenario_path, session_path;
  std::filesystem::path ct_path, labels_path, transform_path, exercise_path;
  std::vector<std::string> changes;
  std::string series, png = "events", labels_in_image = "none";
  bool explain = false, check = false;
  acus::replay::ReplayOptions options;

  CLI::App app{
      "Replay a recorded session through a scenario: forces at every sample, ultrasound and CT\n"
      "images, metrics and a report.",
      "acus-replay"};
  app.add_option("scenario", scenario_path,
                 "Scenario (acus-scenario JSON): a file, or a preset such as\n"
                 "scenarios/lumbar_puncture.json")
      ->required();
  app.add_option("session", session_path,
                 "Session folder, PLUS .igs.mha/.igs.nrrd, or folder of Slicer sequences")
      ->check(CLI::ExistingPath);
  app.add_option("--ct", ct_path, "The patient's CT, in place of the scenario's")
      ->check(CLI::ExistingPath);
  app.add_option("--series", series, "Of a DICOM folder: the UID, or a part of it");
  app.add_option("--labels", labels_path, "The patient's label map, in place of the scenario's")
      ->check(CLI::ExistingFile);
  app.add_option("--transform", transform_path,
                 "ct_from_reference.tfm of acus-register in place of the scenario's, or identity")
      ->check(CLI::ExistingFile | CLI::IsMember({"identity"}));
  app.add_option("--set", changes,
                 "Change one value of the scenario: /json/pointer=value; =null takes it out");
  app.add_option("-o,--output", options.run_folder, "Run folder to make");
  app.add_option("--exercise", exercise_path,
                 "Goals to judge the session by (acus-exercise JSON): a file, or a preset such as\n"
                 "exercises/lumbar_puncture.json");
  app.add_option("--trainee", options.trainee, "Code of the trainee, kept in training.json");
  app.add_option("--png", png, "Frames as PNG: those at events (the default), all, or none")
      ->check(CLI::IsMember({"events", "all", "none"}));
  app.add_flag("!--no-film", options.film, "Write no video");
  app.add_flag("!--no-sequence", options.sequence, "Write no images.igs.mha");
  app.add_flag("!--no-times", options.times,
               "Write no measured times: the same inputs then give the same bytes");
  app.add_option("--labels-in-image", labels_in_image,
                 "Write labelled/: images with labels, poses and forces; png, nifti, hdf5 or none")
      ->check(CLI::IsMember(acus::replay::LabelFormats()));
  app.add_flag("--trace", options.trace, "Write what every stage gave, for acus-regression bisect");
  app.add_flag("--explain", explain,
               "Print the effect plan: stages and why they are in, out or asleep, what they read\n"
               "and write, measured cost. Without a session: what is known beforehand");
  app.add_flag("--check", check, "Load everything as a run does, up to its first step");
  app.callback([&] {
    check = check || (explain && session_path.empty());
    if (session_path.empty() && !check) throw CLI::RequiredError("session");
  });
  app.footer(
      "EXAMPLE\n  acus-replay scenario.json session --ct ct.nrrd --labels labels.seg.nrrd "
      "--transform identity -o run --explain\n"
      "  The report is then run/report.html.");

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::vector<acus::scenario::Override> overrides;
    for (const std::string& change : changes) {
      overrides.push_back(acus::scenario::ParseOverride(change));
    }
    const auto set_path = [&overrides](const char* pointer, const std::filesystem::path& path) {
      if (!path.empty()) overrides.push_back({pointer, path.string()});
    };
    set_path("/patient/ct", ct_path);
    set_path("/patient/series", series);
    set_path("/patient/labels", labels_path);
    set_path("/patient/ct_from_reference_file", transform_path);
    options.png = acus::replay::PngChoices().at(png);
    options.labels = acus::replay::LabelFormats().at(labels_in_image);
    const auto file = acus::config::FindConfig(scenario_path, std::filesystem::current_path());
    const auto scenario = acus::scenario::ReadScenario(file, overrides);
    context.provenance.AddInput(file);
    if (!exercise_path.empty()) {
      options.exercise = acus::config::FindConfig(exercise_path, std::filesystem::current_path());
    }
    if (check) {
      using acus::replay::PlanDetail;
      if (!explain || !session_path.empty()) {
        acus::replay::RequireRunnable(scenario, session_path, options, context);
      }
      const auto detail = explain ? PlanDetail::kAll : PlanDetail::kStages;
      std::cout << acus::replay::CheckText(scenario, session_path, detail, context);
      return acus::ExitCode::kOk;
    }
    const auto result = acus::replay::ReplaySession(scenario, session_path, options, context);
    if (explain) std::cout << result.plan_text;
    std::cout << result.summary;
    return acus::ExitCode::kOk;
  });
}
