// The effect plan for people: which stages run, why, what they read, and what they cost.
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
/// runs, share of them asleep, CPU ms in all, us per run, share of all stages' CPU time. Without
/// `times` only what is known beforehand.
PlanTable TableOfPlan(const simulation::EffectPlan& plan, const simulation::StageTimes* times);

/// What each stage in the plan reads and writes.
PlanTable FlowOfPlan(const simulation::EffectPlan& plan);

/// "needle force: needle outside the tissue in 34 % of the steps", the longest sleeper first.
std::vector<std::string> SleepLines(const simulation::EffectPlan& plan,
                                    const simulation::StageTimes& times);

/// All of it as text for a terminal. Null: nothing has run yet.
std::string PlanText(const simulation::EffectPlan& plan, const simulation::StageTimes* times);

}  // namespace acus::replay
