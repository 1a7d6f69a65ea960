#include "acus/assess/trials/simulate_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/trials/patient_options.h"
#include "acus/assess/trials/trainee_session.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/session_io.h"
#include "acus/run/replay/run_metrics.h"

namespace acus::trials {
namespace {

namespace fs = std::filesystem;

struct SimulateOptions {
  PatientOptions patient;
  std::vector<fs::path> trainees;
  std::vector<std::string> codes;
  int trials = 3;
  double rate_hz = 1000.0;
  bool sessions = true;
  fs::path output;
};

/// One trial of one person.
struct Job {
  TraineeSkill grade;
  std::string code;
  int trial = 1;
};

/// "novice_1" etc., unless the user gives codes.
std::vector<std::string> CodesFor(const SimulateOptions& options) {
  if (options.codes.empty()) {
    std::vector<std::string> codes;
    for (const fs::path& trainee : options.trainees) codes.push_back(trainee.stem().string());
    return codes;
  }
  ACUS_REQUIRE(options.codes.size() % options.trainees.size() == 0,
               "--codes: ", options.codes.size(), " codes for ", options.trainees.size(),
               " trainees; give the same number to each");
  return options.codes;
}

std::vector<Job> JobsOf(const SimulateOptions& options, RunContext& context) {
  const std::vector<std::string> codes = CodesFor(options);
  const std::size_t persons = codes.size() / options.trainees.size();
  std::vector<Job> jobs;
  for (std::size_t t = 0; t < options.trainees.size(); ++t) {
    const fs::path file = config::FindConfig(options.trainees[t], fs::current_path());
    context.provenance.AddInput(file);
    const TraineeSkill grade = ReadTraineeSkill(file);
    for (std::size_t p = 0; p < persons; ++p) {
      const std::string& code = codes[t * persons + p];
      ACUS_REQUIRE(!code.empty() && code.find_first_of("/\\, \t\n") == std::string::npos &&
                       code.front() != '.',
                   "--codes: \"", code,
                   "\" must be a plain word without blanks, commas or slashes");
      for (int trial = 1; trial <= options.trials; ++trial) jobs.push_back({grade, code, trial});
    }
  }
  return jobs;
}

std::string RowOf(const Job& job, const SimulatedTrial& made, const TrialResult& result) {
  const training::Assessment& a = result.assessment;
  return Message(job.code, " trial ", job.trial, ": ", a.NumMet(), " of ", a.goals.size(),
                 " goals met, ", Counted(made.num_corrections, "correction"), "\n");
}

/// @returns a line for the terminal.
std::string RunJob(const Job& job, const TrialScene& scene, const PlannedPath& path,
                   const SimulateOptions& options, const fs::path& folder,
                   const RunContext& context) {
  const SimulatedTrial made =
      SimulateTrial(scene, path, job.grade, job.code, job.trial, context.seed, options.rate_hz);
  TrialResult result = RunTrial(scene, made.session, context);
  result.assessment.trainee = job.code;
  result.assessment.by_virtual_trainee = true;
  const fs::path into = folder / job.code / Message("trial_", job.trial);
  fs::create_directories(into);
  replay::WriteMetrics(into / "metrics.json", result.assessment.metrics);
  config::WriteJson(into / "training.json", training::ToJson(result.assessment));
  replay::WriteEvents(into / "events.csv", result.events);
  if (options.sessions) session::WriteSession(into / "session", made.session, context);
  return RowOf(job, made, result);
}

std::string Run(const SimulateOptions& options, RunContext& context) {
  const std::vector<Job> jobs = JobsOf(options, context);
  AtomicFolder folder(options.output, context.overwrite);
  const scenario::Scenario scenario = options.patient.Scenario(context);
  const TrialScene scene =
      LoadTrialScene(scenario, options.patient.ExerciseFile(), LikeTrainees(), context);
  const PlannedPath path = PlannedPathOf(scene);
  context.provenance.AddInput(scenario.patient.corridor);
  std::vector<std::string> rows(jobs.size());
  const std::size_t piece = std::max<std::size_t>(1, jobs.size() / 50);
  for (std::size_t from = 0; from < jobs.size(); from += piece) {
    context.Checkpoint("trials", static_cast<double>(from) / static_cast<double>(jobs.size()));
    const std::size_t count = std::min(piece, jobs.size() - from);
    ParallelFor(static_cast<int>(count), context.num_threads, [&](int i) {
      const std::size_t n = from + static_cast<std::size_t>(i);
      rows[n] = RunJob(jobs[n], scene, path, options, folder.path(), context);
    });
  }
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  std::string text;
  for (const std::string& row : rows) text += row;
  return text;
}

}  // namespace

std::function<std::string(RunContext& context)> AddSimulateOptions(CLI::App& command) {
  const auto options = std::make_shared<SimulateOptions>();
  options->patient.AddTo(command);
  command
      .add_option("--trainee", options->trainees,
                  "Skill (acus-trainee JSON), joined by commas: files, or presets such as\n"
                  "trainees/novice.json")
      ->required()
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option("--codes", options->codes,
                  "Codes of the persons, joined by commas: as many for each --trainee; default:\n"
                  "one person each, named as its file")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--trials", options->trials, "Trials of each person, in order")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--rate-hz", options->rate_hz, "Samples of the needle per second")
      ->check(CLI::Range(50.0, 10000.0))
      ->capture_default_str();
  command.add_flag("!--no-sessions", options->sessions,
                   "Write no sessions, only training.json and metrics.json of each trial");
  command
      .add_option(
          "-o,--output", options->output,
          "Folder to make: CODE/trial_1/{session, training.json, metrics.json, events.csv}, ...")
      ->required();
  return [options](RunContext& context) { return Run(*options, context); };
}

}  // namespace acus::trials
