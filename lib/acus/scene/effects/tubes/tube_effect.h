// The parts that effects with moving tube walls share: settings, inputs, parameters.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "acus/scene/effects/effect.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/effects/tubes/tube.h"

namespace acus::effects {

/// The paths among the settings of a tube effect.
/// @param centrelines  The port of the effect's file of centrelines.
std::vector<PathSetting> TubePaths(const ports::FilePort& centrelines);

/// A stage that reads the centrelines, or else the label map, and moves the tissue.
StageDeclaration TubeStage(std::string_view name, const ports::FilePort& centrelines,
                           const nlohmann::json& settings);

/// Parameters of the settings reach_mm, point_spacing_mm and warp_spacing_mm.
/// @param prefix  First part of their names: "vessel". @param one, all  "a pulsating vessel",
///     "vessels", for their titles.
std::vector<Knob> TubeKnobs(const std::string& prefix, const std::string& one,
                            const std::string& all);

/// Tubes from the file of centrelines or the label map; none if no centreline is found in the map.
/// @throws InputError as ReadCentrelines, or if the tissue would fold by `largest_strain`.
std::vector<Tube> TubesOf(const nlohmann::json& settings, const PortValues& scene,
                          double largest_strain, RunContext& context);

}  // namespace acus::effects
