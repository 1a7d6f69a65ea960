// acus-training: the sessions of trainees, one after the other.
#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "acus/assess/study/curriculum_command.h"
#include "acus/assess/study/reference_page.h"
#include "acus/assess/trials/difficulty_command.h"
#include "acus/assess/trials/simulate_command.h"
#include "acus/assess/trials/what_if_command.h"
#include "acus/base/core/run_main.h"
#include "acus/run/training/discarded.h"
#include "acus/run/training/progress.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  std::vector<fs::path> runs, reference;
  fs::path output;
  CLI::App app{
      "Put the sessions of an exercise side by side: goals met, values, how they change.\n"
      "Each run folder comes from acus-replay --exercise. Or: what a trial would have been\n"
      "with another insertion, trials of virtual trainees, and the state of a curriculum.",
      "acus-training"};
  app.add_option("runs", runs, "Run folders, in the order of the sessions")
      ->check(CLI::ExistingDirectory);
  app.add_option("-o,--output", output,
                 "Folder to make: progress.html, progress.csv; with --reference, reference.csv");
  app.add_option(
         "--reference", reference,
         "Folders that hold training.json of other persons at any depth, joined by commas:\n"
         "the newest session beside this group and the earlier sessions")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  app.require_subcommand(0, 1);
  app.fallthrough();
  CLI::App* what_if = app.add_subcommand(
      "what-if", "Other insertions in the trial's patient, ranked by the exercise's goals");
  const auto run_what_if = acus::trials::AddWhatIfOptions(*what_if);
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Trials of virtual trainees, whose hands and eyes are as good as their grade");
  const auto run_simulate = acus::trials::AddSimulateOptions(*simulate);
  CLI::App* curriculum = app.add_subcommand(
      "curriculum", "Which exercises each trainee has mastered, and which is next");
  const auto run_curriculum = acus::study::AddCurriculumOptions(*curriculum);
  CLI::App* difficulty = app.add_subcommand(
      "difficulty", "How difficult exercises are for virtual trainees: cases of a curriculum");
  const auto run_difficulty = acus::trials::AddDifficultyOptions(*difficulty);
  app.callback([&] {
    if (runs.empty() && app.get_subcommands().empty()) throw CLI::RequiredError("runs");
  });
  app.footer(
      "EXAMPLE\n"
      "  acus-training first_run second_run -o progress\n"
      "  acus-training what-if scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \\\n"
      "    --transform ct_from_reference.tfm --set /patient/corridor=target.csv \\\n"
      "    --exercise exercises/lumbar_puncture.json --count 50 -o what_if\n"
      "  acus-training simulate scenario.json --ct ct.nrrd --labels labels.seg.nrrd \\\n"
      "    --transform ct_from_reference.tfm --set /patient/corridor=corridor_ct.csv \\\n"
      "    --exercise exercises/lumbar_puncture.json --trainee trainees/expert.json \\\n"
      "    --rate-hz 200 -o experts\n"
      "  acus-training curriculum curricula/four_punctures.json --trials trainees\n"
      "  The pages are then progress/progress.html and what_if/what_if.html.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    for (const auto& [command, run] : {std::pair{what_if, &run_what_if},
                                       {simulate, &run_simulate},
                                       {curriculum, &run_curriculum},
                                       {difficulty, &run_difficulty}}) {
      if (!command->parsed()) continue;
      std::cout << (*run)(context) << std::flush;
      return acus::ExitCode::kOk;
    }
    runs = acus::training::KeptRuns(runs, context);
    for (const fs::path& run : runs) {
      if (fs::exists(run / "training.json")) context.provenance.AddInput(run / "training.json");
    }
    const auto sessions = acus::training::ReadAssessments(runs);
    std::optional<acus::study::GroupComparison> group;
    if (!reference.empty()) {
      group = acus::study::CompareWithGroup(sessions, reference, context);
    }
    if (!output.empty()) acus::study::WriteProgress(output, sessions, group, context);
    std::cout << acus::training::ProgressText(sessions)
              << (group ? acus::study::ReferenceText(*group) : "") << std::flush;
    return acus::ExitCode::kOk;
  });
}
