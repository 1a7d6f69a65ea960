// The effect plan as text: which stages run, why, their inputs, and their cost.
#pragma once

#include <string>
#include <vector>

#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::replay {

struct PlanTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// Header and rows: stage, rate, in or out (or asleep, if it never had anything to do), reason,
/// runs, share of them asleep, total CPU ms, us per run, share of all stages' CPU time. Without
/// `times` only the columns that do not need a run.
PlanTable TableOfPlan(const simulation::EffectPlan& plan, const simulation::StageTimes* times);

/// The inputs and outputs of each stage in the plan.
PlanTable FlowOfPlan(const simulation::EffectPlan& plan);

/// "needle force: needle outside the tissue in 34 % of the steps", the longest sleep first.
std::vector<std::string> SleepLines(const simulation::EffectPlan& plan,
                                    const simulation::StageTimes& times);

/// All of it as text for a terminal. @param times  Null: before a run.
std::string PlanText(const simulation::EffectPlan& plan, const simulation::StageTimes* times);

}  // namespace acus::replay
