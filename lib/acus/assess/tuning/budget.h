// The setting for a budget of time or for an accuracy, on this machine: measured, chosen,
// explained.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/choice.h"
#include "acus/assess/tuning/run_store.h"
#include "acus/assess/tuning/sweep_plan.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/core/run_context.h"
#include "acus/scene/scenario/evidence.h"

namespace acus::tuning {

/// What is asked.
struct BudgetQuestion {
  Goal goal;
  std::string asked;  ///< As on the command line.
  /// The goal is what a live session needs: a setting that keeps it as it is given is the answer,
  /// even if a more accurate one would keep it too.
  bool live = false;
};

/// A setting that was measured, over all its repetitions. Times are the least of them: what others
/// do to the machine only ever adds time. Errors are means.
struct MeasuredSetting {
  ValueIndices indices;
  std::vector<Measured> runs;
  scenario::Cost cost;
  double force_rms_n = kNotMeasured;
  double image_psnr_db = kNotMeasured;  ///< Infinite where all images are the same.
  double image_ssim = kNotMeasured;
  std::vector<scenario::EvidenceStage>
      stages;  ///< Means over repetitions, the most expensive first.
  std::string unusable;
};

struct BudgetAnswer {
  BudgetQuestion question;
  SweepPlan plan;  ///< With the knobs that were turned, and as cases all that was run.
  Choice choice;
  std::vector<MeasuredSetting> measured;  ///< As in choice.measured.
  MeasuredSetting most_expensive;         ///< What all errors are against.

  bool Found() const { return choice.chosen.has_value(); }
  /// The chosen one, or the one that comes nearest to the goal.
  const MeasuredSetting& Best() const { return measured[choice.chosen.value_or(choice.nearest)]; }
  const MeasuredSetting& Given() const { return measured.front(); }
};

/// The plan of a question: of the knobs that the user names, or else of all that are numbers or
/// truth values. Which model is simulated is the user's to say, and how fast samples come is the
/// device's. It has no cases yet. @throws InputError as MakePlan, and for step_rate_hz.
SweepPlan MakeBudgetPlan(const SweepRequest& request, const RunContext& context);

/// A goal as far as the scene has the parts that it names, for questions that name both.
/// @throws InputError if it has none.
Goal LiveGoalOf(const SweepPlan& plan, const RunContext& context);

/// Measures and chooses. Runs that are in the store are not run again.
/// @throws InputError if the scene lacks a part that the goal names.
BudgetAnswer AnswerQuestion(const BudgetQuestion& question, SweepPlan plan, const RunStore& store,
                            RunContext& context);

/// Where the knobs stand, all of them.
Setting SettingOf(const std::vector<Knob>& knobs, const ValueIndices& indices);

/// What was measured, for tables and plots: the sweep of each knob with the others as given, then
/// settings that turn several. All are compared with the most expensive of all.
SweepResult ResultOf(const BudgetAnswer& answer);

/// In plain sentences: what was chosen, what it takes and how far off it is, what is gained on the
/// setting as given, where the time goes. If nothing was found: what the nearest takes, and why.
std::string AnswerText(const BudgetAnswer& answer);

}  // namespace acus::tuning
