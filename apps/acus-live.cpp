// acus-live: a training session with devices.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/base/core/text_table.h"
#include "acus/run/live/live_session.h"
#include "acus/run/replay/replay.h"
#include "acus/run/training/exercise.h"
#include "acus/window/run_with_window.h"

int main(int argc, char** argv) {
  std::filesystem::path scenario_path, devices_path, exercise_path;
  std::vector<std::string> changes;
  bool headless = false, left_handed = false;
  acus::live::LiveOptions options;
  acus::window::ConsoleSettings console;

  CLI::App app{
      "Run a training session: forces at the rate of the device, images beside it, all of it\n"
      "recorded in a session folder that acus-replay reproduces bit for bit.",
      "acus-live"};
  app.add_option("scenario", scenario_path, "Scenario (acus-scenario JSON): a file or a preset")
      ->required();
  app.add_option("--devices", devices_path,
                 "What is attached (acus-devices JSON): a file, or a preset such as\n"
                 "devices/virtual.json")
      ->required();
  app.add_option("-o,--output", options.session_folder, "Session folder to make");
  app.add_option("--hand", options.hand, "Virtual hands follow this recorded session")
      ->check(CLI::ExistingPath);
  app.add_option("--duration", options.duration_s, "End by itself after so many seconds")
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--exercise", exercise_path, "What the trainee is asked to do (acus-exercise)")
      ->check(CLI::ExistingFile);
  app.add_option("--trial", console.trial, "Which trial of the trainee it is: hints fade with it")
      ->check(CLI::Range(1, 100000));
  app.add_option("--set", changes,
                 "Change one value of the scenario: /json/pointer=value; =null takes it out");
  app.add_flag("--headless", headless, "Without a window; otherwise there must be a display");
  app.add_flag("--left-handed", left_handed,
               "Exchange the devices of needle and probe that the devices file names");
  app.add_option("--views", console.views,
                 "Views to show, with commas: camera, ultrasound, 3d, volume, ct, effects.\n"
                 "Without it all but volume, which the key M brings");
  app.add_option("--screenshot", console.screenshot, "PNG of the window, taken at the end");
  app.add_flag("--check", options.only_checks,
               "Check scenario, files and devices; start nothing, and load no driver: say which\n"
               "library each device has");
  app.callback([&] {
    if (options.session_folder.empty() && !options.only_checks)
      throw CLI::RequiredError("--output");
  });
  app.footer(
      "EXAMPLE\n"
      "  acus-live scenario.json --devices devices/virtual.json --hand session --headless \\\n"
      "    --duration 2 -o live_session --set /patient/ct=ct.nrrd \\\n"
      "    --set /patient/labels=labels.seg.nrrd --overwrite\n"
      "  acus-replay scenario.json live_session --ct ct.nrrd --labels labels.seg.nrrd -o live_run\n"
      "  live_run/forces.csv is then live_session/forces.csv, byte for byte.");

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::vector<acus::scenario::Override> overrides;
    for (const auto& change : changes) {
      overrides.push_back(acus::scenario::ParseOverride(change));
    }
    const auto here = std::filesystem::current_path();
    const auto scenario =
        acus::scenario::ReadScenario(acus::config::FindConfig(scenario_path, here), overrides);
    auto devices = acus::live::ReadLiveDevices(acus::config::FindConfig(devices_path, here));
    if (left_handed) devices.haptics.SwapHands();
    if (!exercise_path.empty()) {
      options.exercise = acus::training::ReadExercise(exercise_path);
      options.name = options.exercise->name;
      context.provenance.AddInput(exercise_path);
    }
    acus::live::LiveSession session(scenario, devices, options, context);
    if (options.only_checks) {
      std::cout << acus::replay::CheckText(scenario, {}, acus::replay::PlanDetail::kStages, context)
                << session.DevicesText();
      return acus::ExitCode::kOk;
    }
    bool good = false;
    if (headless) {
      good = acus::live::RunHeadless(session, context);
    } else {
      const auto run = acus::window::RunWithWindow(scenario, session, console, context);
      good = run.complete;
      std::cout << "Window: " << acus::FixedText(run.frames_per_s, 1) << " frames a second.\n";
    }
    std::cout << session.SummaryText();
    return good ? acus::ExitCode::kOk : acus::ExitCode::kNoAnswer;
  });
}
