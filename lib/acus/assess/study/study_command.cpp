#include "acus/assess/study/study_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/study/study_export.h"
#include "acus/assess/study/study_report.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;

struct StudyOptions {
  fs::path study;
  std::vector<fs::path> trials;
  fs::path answers;
  fs::path consents;
  fs::path output;
};

Study ReadStudyOf(const StudyOptions& options, RunContext& context) {
  const fs::path file = config::FindConfig(options.study, fs::current_path());
  context.provenance.AddInput(file);
  Study study = ReadStudy(file);
  if (!options.consents.empty()) ReadConsents(options.consents, study, context);
  return study;
}

std::string RunPlan(const StudyOptions& options, RunContext& context) {
  const Study study = ReadStudyOf(options, context);
  AtomicFolder folder(options.output, context.overwrite);
  WriteTextFile(folder.path() / "order.csv", OrderCsv(study));
  if (!study.questionnaires.empty()) {
    WriteTextFile(folder.path() / "answers.csv", EmptyAnswersCsv(study));
  }
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return Message(Counted(static_cast<std::int64_t>(study.participants.size()), "participant"), ", ",
                 Counted(static_cast<std::int64_t>(study.exercises.size()), "exercise"), " of ",
                 Counted(study.trials, "trial"), " each: ", (options.output / "order.csv").string(),
                 "\n");
}

std::string RunReport(const StudyOptions& options, RunContext& context) {
  const Study study = ReadStudyOf(options, context);
  AtomicFolder folder(options.output, context.overwrite);
  const auto trials = ReadTrials(options.trials, study, context);
  std::vector<Answer> answers;
  if (!options.answers.empty()) answers = ReadAnswers(options.answers, study, context);
  const StudyAnalysis analysis = Analyse(study, trials, answers);
  WriteStudyReport(folder.path(), study, trials, answers, analysis, context);
  folder.Commit();
  return StudyText(study, trials, analysis) +
         "Report: " + (options.output / "study.html").string() + "\n";
}

std::string RunExport(const StudyOptions& options, RunContext& context) {
  const Study study = ReadStudyOf(options, context);
  AtomicFolder folder(options.output, context.overwrite);
  const auto trials = ReadTrials(options.trials, study, context);
  WriteBids(folder.path(), study, trials, context);
  folder.Commit();
  return Message(Counted(static_cast<std::int64_t>(trials.size()), "trial"), ": ",
                 options.output.string(), "\n");
}

}  // namespace

std::function<std::string(RunContext& context)> AddStudyCommands(CLI::App& app) {
  const auto options = std::make_shared<StudyOptions>();
  const auto add = [&](const char* name, const char* description, const char* output) {
    CLI::App* command = app.add_subcommand(name, description);
    command->add_option("study", options->study, "Study (acus-study JSON): a file, or a preset")
        ->required();
    command->add_option("-o,--output", options->output, output)->required();
    return command;
  };
  const auto add_trials = [&](CLI::App& command) {
    command
        .add_option("--trials", options->trials,
                    "Folders that hold training.json of trials at any depth, or a trials.csv;\n"
                    "several joined by commas")
        ->required()
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::ExistingPath);
    command
        .add_option("--consent", options->consents,
                    "consent.csv of pipelines/training-day: its answers take the place of the\n"
                    "study's")
        ->check(CLI::ExistingFile);
  };
  CLI::App* plan = add("plan", "The order of the exercises for each participant, by the seed",
                       "Folder to make: order.csv, and answers.csv to fill in");
  CLI::App* report = add("report", "Tables, tests, effect sizes, reliability and box plots",
                         "Folder to make: study.html, and tables as CSV");
  add_trials(*report);
  report->add_option("--answers", options->answers, "answers.csv, filled in")
      ->check(CLI::ExistingFile);
  CLI::App* bids = add("export", "Trials with their events as tables for other programs (BIDS)",
                       "Folder to make: participants.tsv, sub-CODE/beh/...");
  add_trials(*bids);
  return [=](RunContext& context) {
    if (plan->parsed()) return RunPlan(*options, context);
    return report->parsed() ? RunReport(*options, context) : RunExport(*options, context);
  };
}

}  // namespace acus::study
