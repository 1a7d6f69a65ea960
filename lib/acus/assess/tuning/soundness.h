// Bounds that no setting may violate: an unstable solver can look fast.
#pragma once

#include <string>

#include "acus/run/replay/step_log.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"

namespace acus::tuning {

/// Why a run must not be used: a force that is not finite or above its limit, or energy that the
/// hand received beyond its work. Empty: it may be used.
std::string WhyUnusable(const scenario::Scenario& scenario, const simulation::Scene& scene,
                        const replay::StepLog& log);

}  // namespace acus::tuning
