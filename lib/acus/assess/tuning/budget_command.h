// The options of `acus-tradeoff scene` that request a setting, and their execution.
#pragma once

#include <filesystem>
#include <string>

#include "acus/assess/tuning/sweep_plan.h"
#include "acus/base/core/run_context.h"

namespace CLI {
class App;
}

namespace acus::tuning {

/// At most one of them is set.
struct BudgetOptions {
  std::string budget;
  std::string accuracy;
  bool live = false;

  bool AnyGiven() const { return live || !budget.empty() || !accuracy.empty(); }
};

/// Adds --budget, --accuracy and --live; they write into `options`, which must outlive the command.
void AddBudgetOptions(CLI::App& command, BudgetOptions& options);

/// Measures, chooses, and writes tables, page and - if a setting was found - scenario.json into
/// `folder`. @returns the text for the terminal.
/// @throws InputError as MakeBudgetPlan and AnswerQuestion; NoAnswerError if no measured setting
///     meets the goal: the message then states the cost of the closest one, and there is no
///     scenario.json.
std::string RunBudget(const BudgetOptions& options, const SweepRequest& request,
                      const std::filesystem::path& folder, RunContext& context);

}  // namespace acus::tuning
