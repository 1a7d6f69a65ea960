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

/// A request for a setting.
struct BudgetQuestion {
  Goal goal;
  std::string asked;  ///< As on the command line.
  /// The goal is that of a live session: if the scenario's setting meets it, that is the answer,
  /// even if a more accurate one would meet it too.
  bool live = false;
};

/// A measured setting, over all its repetitions. Times are the minimum: other load on the machine
/// only adds time. Errors are means.
struct MeasuredSetting {
  ValueIndices indices;
  std::vector<Measured> runs;
  scenario::Cost cost;
  double force_rms_n = kNotMeasured;
  double image_psnr_db = kNotMeasured;  ///< Infinite if all images are the same.
  double image_ssim = kNotMeasured;
  std::vector<scenario::EvidenceStage>
      stages;  ///< Means over repetitions, the most expensive first.
  std::string unusable;
};

struct BudgetAnswer {
  BudgetQuestion question;
  SweepPlan plan;  ///< Contains the parameters that were varied, and all runs as cases.
  Choice choice;
  std::vector<MeasuredSetting> measured;  ///< As in choice.measured.
  MeasuredSetting most_expensive;         ///< The reference of all errors.

  bool Found() const { return choice.chosen.has_value(); }
  /// The chosen one, or the one closest to the goal.
  const MeasuredSetting& Best() const { return measured[choice.chosen.value_or(choice.nearest)]; }
  const MeasuredSetting& Given() const { return measured.front(); }
};

/// The plan of a request: for the parameters that the user names, or else for all that are numbers
/// or truth values. The user decides which model is simulated, and the device the sampling rate. It
/// has no cases yet. @throws InputError as MakePlan, and for step_rate_hz.
SweepPlan MakeBudgetPlan(const SweepRequest& request, const RunContext& context);

/// The parts of a goal for both forces and images that the scene has.
/// @throws InputError if it has none.
Goal LiveGoalOf(const SweepPlan& plan, const RunContext& context);

/// Measures and chooses. Runs that are in the store are not repeated.
/// @throws InputError if the scene lacks a part that the goal names.
BudgetAnswer AnswerQuestion(const BudgetQuestion& question, SweepPlan plan, const RunStore& store,
                            RunContext& context);

/// The values of all parameters.
Setting SettingOf(const std::vector<Knob>& knobs, const ValueIndices& indices);

/// The measurements, for tables and plots: the sweep of each parameter with the others at the
/// scenario's values, then settings that vary several. All are compared with the most expensive of
/// all.
SweepResult ResultOf(const BudgetAnswer& answer);

/// The answer in sentences: the chosen setting, its cost and error, the gain over the scenario's
/// setting, and the shares of the time. Without an answer: the cost of the closest setting, and the
/// reason.
std::string AnswerText(const BudgetAnswer& answer);

}  // namespace acus::tuning
