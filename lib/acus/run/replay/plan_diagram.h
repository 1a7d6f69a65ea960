// The effect plan as an image: inputs, stages, outputs, and what flows between them.
#pragma once

#include <string>

#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::replay {

/// SVG. Stages that are out are grey; of those that are in, the share of runs asleep is hatched and
/// a bar shows the share of CPU time. Tooltips tell the reasons.
std::string PlanSvg(const simulation::EffectPlan& plan, const simulation::StageTimes& times);

}  // namespace acus::replay
