// A planned sweep, run: what is there already is not run again.
#pragma once

#include <string>

#include "acus/assess/tuning/run_store.h"
#include "acus/assess/tuning/sweep_plan.h"
#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// Runs a setting of the plan's knobs, in the plan or not, with the seed of that repetition. Its
/// errors are not filled in: Compare its series with that of a reference for that.
/// @throws InputError as RunCase.
CaseRun RunSetting(const SweepPlan& plan, const Setting& setting, int repetition,
                   RunContext& context);

/// How near to an event two settings' forces are not compared: two steps of the slower one, s.
double AroundEventS(const SweepPlan& plan, const Setting& a, const Setting& b);

/// How much of a plan there is.
struct Progress {
  int planned = 0;
  int done = 0;
};
Progress ProgressOf(const SweepPlan& plan, const RunStore& store);

/// Runs the cases that are not there, or only the one that is named (`only_case`, if not empty)
/// with the reference that it needs. Several processes may do so in the same folder. Stopping at
/// any moment loses the case that is running, no other.
/// @throws InputError if there is no case of that name, or an input is not usable.
void RunCases(const SweepPlan& plan, const RunStore& store, const std::string& only_case,
              RunContext& context);

/// What runs say: statistics of each setting, and what they are of. @param runs  One of each case.
SweepResult Summarise(const SweepPlan& plan, std::vector<Measured> runs);

/// What the finished runs say. @throws InputError if some are missing, saying how many.
SweepResult Collect(const SweepPlan& plan, const RunStore& store);

/// Statistics over repetitions of each setting of the plan. @param runs  One of each case.
std::vector<SettingResult> SettingsOf(const SweepPlan& plan, const std::vector<Measured>& runs);

}  // namespace acus::tuning
