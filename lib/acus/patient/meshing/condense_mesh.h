// The condensation of a mesh, as acus-mesh does it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/meshing/lattice_points.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::meshing {

struct CondenseSettings {
  double corridor_radius_mm = 0.0;
  double tip_reach_mm = 0.0;
  std::optional<mechanics::SkinPatch> probe;
  double image_radius_mm = 0.0;  ///< 0: no image block.
  mechanics::Storage storage = mechanics::Storage::kDouble;
  mechanics::ElementKind element = mechanics::ElementKind::kAveragedDilatation;
  mechanics::ElasticityTable elasticity;
  double max_memory_mib = 0.0;
};

/// @param document  Of format acus-mesh/1, checked and with defaults (config::ReadConfig).
/// @param relative_to  Folder that names of files in it are relative to.
/// @param probe_at  "x,y,z" in mm instead of the configuration's place; empty: as it is there.
/// @throws InputError if the element or the elasticity table cannot be used.
CondenseSettings CondenseSettingsFromJson(const nlohmann::json& document,
                                          const std::filesystem::path& relative_to,
                                          const std::string& probe_at);

/// Writes compliance.acc and condensation.json (sizes, CPU times, peak memory, hashes) to `folder`.
/// @param corridor  The needle's way.
/// @throws as mechanics::FindFreeNodes, CorridorNodes, SkinNodes, Condensation, WriteCompliance.
void WriteCondensed(const std::filesystem::path& folder, const mesh::TetraMesh& mesh,
                    const Corridor& corridor, const CondenseSettings& settings,
                    const RunContext& context);

}  // namespace acus::meshing
