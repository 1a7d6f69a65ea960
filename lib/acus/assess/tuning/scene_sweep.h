// Runs a planned sweep; finished runs are not repeated.
#pragma once

#include <string>

#include "acus/assess/tuning/run_store.h"
#include "acus/assess/tuning/sweep_plan.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// Runs a setting of the plan's parameters, in the plan or not, with the seed of that repetition.
/// Its errors are not filled in: for them, Compare its series with that of a reference.
/// @throws InputError as RunCase.
CaseRun RunSetting(const SweepPlan& plan, const Setting& setting, int repetition,
                   RunContext& context);

/// Margin around an event in which two settings' forces are not compared: two of the longer steps,
/// s.
double AroundEventS(const SweepPlan& plan, const Setting& a, const Setting& b);

/// Number of finished and planned runs.
struct Progress {
  int planned = 0;
  int done = 0;
};
Progress ProgressOf(const SweepPlan& plan, const RunStore& store);

/// Runs the missing cases, or only the named one (`only_case`, if not empty) with the reference
/// that it needs. Several processes may do so in the same folder. A stop loses only the case that
/// is running.
/// @throws InputError if there is no case of that name, or an input is not usable.
void RunCases(const SweepPlan& plan, const RunStore& store, const std::string& only_case,
              RunContext& context);

/// Statistics of each setting with their context. @param runs  One of each case.
SweepResult Summarise(const SweepPlan& plan, std::vector<Measured> runs);

/// Summarises the finished runs. @throws InputError with the number of missing runs, if any.
SweepResult Collect(const SweepPlan& plan, const RunStore& store);

/// Statistics over repetitions of each setting of the plan. @param runs  One of each case.
std::vector<SettingResult> SettingsOf(const SweepPlan& plan, const std::vector<Measured>& runs);

}  // namespace acus::tuning
