// The effect plan and the costs of its stages, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "acus/scene/simulation/effect_plan.h"
#include "acus/scene/simulation/stage_timing.h"

namespace acus::simulation {

/// An array with an object for each stage: stage, rate, in, reason, effects, reads, writes, runs,
/// asleep, asleep_because (runs by reason; reasons without runs are omitted) and seconds of CPU
/// time.
nlohmann::json PlanJson(const EffectPlan& plan, const StageTimes& times);

}  // namespace acus::simulation
