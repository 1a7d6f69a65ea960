// The effect plan as an image: inputs, stages, outputs, and the data flow between them.
#pragma once

#include <string>

#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::replay {

/// SVG. Stages that are not in the plan are grey; for the others, the share of runs asleep is
/// hatched and a bar shows the share of CPU time. Tooltips give the reasons.
std::string PlanSvg(const simulation::EffectPlan& plan, const simulation::StageTimes& times);

}  // namespace acus::replay
