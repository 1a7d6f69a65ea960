// The effect plan for people: which stages run, why, and what they cost.
#pragma once

#include <string>
#include <vector>

#include "simulation/effect_plan.h"
#include "simulation/simulation.h"

namespace acus::replay {

/// Header and rows: stage, rate, in or out, reason, runs, asleep, ms in all, us per run, share of
/// all stages' time. Times are those of the wall clock, on a busy machine more than CPU time.
/// Without `times` only what is known beforehand.
struct PlanTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
PlanTable TableOfPlan(const simulation::EffectPlan& plan, const simulation::StageTimes* times);

}  // namespace acus::replay
