// What effects that move the walls of tubes have in common: settings, inputs, knobs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "acus/scene/effects/effect.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/effects/tubes/tube.h"

namespace acus::effects {

/// Of the settings tissue, centrelines, reach_mm, point_spacing_mm and warp_spacing_mm.
/// @param centrelines  The effect's own port.
std::vector<PathSetting> TubePaths(const ports::FilePort& centrelines);

/// A stage that reads the centrelines, or else the label map, and moves the tissue.
StageDeclaration TubeStage(std::string_view name, const ports::FilePort& centrelines,
                           const nlohmann::json& settings);

/// @param prefix  "vessel": of the names. @param one, all  "a pulsating vessel", "vessels": of the
///     titles.
std::vector<Knob> TubeKnobs(const std::string& prefix, const std::string& one,
                            const std::string& all);

/// From the file of centrelines or the label map; none if the map has nothing that can be followed.
/// @throws InputError as ReadCentrelines, or if the tissue would fold by `largest_strain`.
std::vector<Tube> TubesOf(const nlohmann::json& settings, const PortValues& scene,
                          double largest_strain, RunContext& context);

}  // namespace acus::effects
