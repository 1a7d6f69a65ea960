#include "acus/assess/tuning/budget_command.h"

#include <CLI/CLI.hpp>

#include "acus/assess/tuning/budget.h"
#include "acus/assess/tuning/budget_scenario.h"
#include "acus/assess/tuning/result_files.h"
#include "acus/assess/tuning/tradeoff_page.h"
#include "acus/base/core/words.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

BudgetQuestion QuestionOf(const BudgetOptions& options, const SweepPlan& plan,
                          const RunContext& context) {
  if (options.live) {
    return {.goal = LiveGoalOf(plan, context), .asked = "--live", .live = true};
  }
  if (!options.budget.empty()) {
    return {.goal = ParseBudget(options.budget), .asked = "--budget " + options.budget};
  }
  return {.goal = ParseAccuracy(options.accuracy), .asked = "--accuracy " + options.accuracy};
}

}  // namespace

void AddBudgetOptions(CLI::App& command, BudgetOptions& options) {
  auto* budget = command.add_option(
      "--budget", options.budget,
      "Choose the most accurate setting that takes at most so much CPU time per force step\n"
      "(99.9th percentile) and per image (95th percentile): force=0.5ms,image=16ms, or one of\n"
      "them; written as scenario.json");
  auto* accuracy = command.add_option(
      "--accuracy", options.accuracy,
      "Choose the cheapest setting within this force error of the most expensive one (RMS)\n"
      "and has images of at least this PSNR: force=0.02N,image=35dB, or one of them");
  auto* live = command.add_flag(
      "--live", options.live,
      "Say whether this machine runs the scene live - a force every 1 ms, the scenario's images\n"
      "per second -, and if not, with which setting it would");
  budget->excludes(accuracy)->excludes(live);
  accuracy->excludes(live);
}

std::string RunBudget(const BudgetOptions& options, const SweepRequest& request,
                      const fs::path& folder, RunContext& context) {
  // An invalid text is an error before anything is read.
  if (!options.budget.empty()) ParseBudget(options.budget);
  if (!options.accuracy.empty()) ParseAccuracy(options.accuracy);
  SweepPlan plan = MakeBudgetPlan(request, context);
  const BudgetQuestion question = QuestionOf(options, plan, context);
  context.provenance.AddInput(request.scene.scenario);
  const RunStore store(folder, IdentityOf(plan), context.overwrite);
  // Removes the answer to an earlier request.
  fs::remove(folder / "scenario.json");
  const BudgetAnswer answer = AnswerQuestion(question, std::move(plan), store, context);

  const std::string text = AnswerText(answer);
  const SweepResult result = ResultOf(answer);
  WriteResult(folder, result, context);
  PageContent page;
  page.answer = LinesOf(text);
  page.remarks = LinesOf(LeftOutText(answer.plan));
  page.plots.goal = question.goal;
  if (answer.Found()) page.plots.chosen = SettingOf(answer.plan.knobs, answer.Best().indices);
  WritePage(folder, result, page, context);
  if (!answer.Found()) {
    throw NoAnswerError(text + "All that was measured is in " +
                        (folder / "tradeoff.html").string());
  }
  WriteChosenScenario(folder / "scenario.json", answer);
  return LeftOutText(answer.plan) + TableText(result) + text +
         "Written: " + (folder / "scenario.json").string() + "\n";
}

}  // namespace acus::tuning
