// The patient of a scenario in the windows of a live session.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"
#include "acus/window/frame.h"

namespace acus::window {

/// Surfaces for the teaching view and the CT that is overlaid on the video: those of
/// effects/view_3d in the scenario, else bone, organs and transparent skin. Windows show the
/// patient whether or not an effect reads the data: volumes that the scene has not loaded are
/// loaded here, if their file exists.
/// @throws InputError if a file is not readable.
PatientOnDisplay PatientOnDisplayOf(const scenario::Scenario& scenario,
                                    const simulation::Scene& scene, const RunContext& context);

}  // namespace acus::window
