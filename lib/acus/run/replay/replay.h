// Replays a recorded session through a scenario, into a run folder.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/run/replay/label_format.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

enum class PngChoice { kEvents, kAll, kNone };

/// Choices by their names on the command line.
std::map<std::string, PngChoice> PngChoices();

struct ReplayOptions {
  std::filesystem::path run_folder;  ///< Empty: nothing is written.
  PngChoice png = PngChoice::kEvents;
  bool film = true;
  bool sequence = true;
  bool times = true;   ///< Write measured times; without them, the same inputs give the same bytes.
  bool trace = false;  ///< Write trace.csv and image_trace.csv, see trace.h.
  LabelFormat labels = LabelFormat::kNone;  ///< Write labelled/, see labelled_images.h.
  std::filesystem::path exercise;           ///< acus-exercise file; empty: none.
  std::string trainee;                      ///< Code of the trainee, for training.json.
};

struct ReplayResult {
  std::string plan_text;  ///< The effect plan with measured cost, as a table.
  std::string summary;    ///< Output files and results, in a few lines.
};

/// Runs every needle sample through Simulation::Step, renders images at the scenario's rate and
/// writes the run folder (docs/reference/formats.md), whole or not at all.
/// The same inputs give the same bytes with any number of threads, except for measured times in
/// run.json and report.html, which options.times switches off.
/// @throws InputError if an effect lacks an input or a file is not usable.
ReplayResult ReplaySession(const scenario::Scenario& scenario,
                           const std::filesystem::path& session_path, const ReplayOptions& options,
                           RunContext& context);

/// Whether the inputs and outputs of stages are listed as well.
enum class PlanDetail { kStages, kAll };

/// The text of `--check`: the effect plan, and that every file that it needs exists.
/// @param session_path  Defines the available inputs; empty: all inputs count as available.
/// @throws InputError if an effect lacks an input.
std::string CheckText(const scenario::Scenario& scenario, const std::filesystem::path& session_path,
                      PlanDetail detail, RunContext& context);

/// Loads the patient, all models, the session and the exercise as ReplaySession does, up to its
/// first step, and keeps nothing: finds every error that a run would report before its first step.
/// @param session_path  May be empty: all inputs of effects then count as available.
/// @param options  Its exercise and run folder are checked; either may be empty.
/// @throws InputError as ReplaySession does.
void RequireRunnable(const scenario::Scenario& scenario, const std::filesystem::path& session_path,
                     const ReplayOptions& options, RunContext& context);

}  // namespace acus::replay
