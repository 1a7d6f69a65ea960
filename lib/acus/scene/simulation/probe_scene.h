// Loads the model of the force on the probe of a scene.
#pragma once

#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"

namespace acus::simulation {

/// Fills in scene.probe_force, how the tool is held, and the fields that the model refers to.
/// @pre the CT, the label map and the probe preset are loaded if the plan reads them.
/// @pre the scenario has effects/probe_force.
/// @throws InputError if the table is not readable or the tool's settings are not allowed.
void LoadProbeForce(const scenario::Scenario& scenario, Scene& scene, const RunContext& context);

}  // namespace acus::simulation
