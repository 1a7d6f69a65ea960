// The patient of a scenario as the windows of a live session show him.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"
#include "acus/window/frame.h"

namespace acus::window {

/// Surfaces for the teaching view and the CT that is laid over the video: what effects/view_3d of
/// the scenario says, else bone, organs and transparent skin. Windows show the patient whether or
/// not an effect reads him: what the scene has not loaded is loaded here, if there is a file of it.
/// @throws InputError if a file is not readable.
PatientOnDisplay PatientOnDisplayOf(const scenario::Scenario& scenario,
                                    const simulation::Scene& scene, const RunContext& context);

}  // namespace acus::window
