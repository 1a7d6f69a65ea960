// Settings of acus-mesh from configs/meshes/*.json.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acus/patient/meshing/condense_mesh.h"
#include "acus/patient/meshing/label_mesher.h"
#include "acus/patient/meshing/surface_mesher.h"

namespace acus::meshing {

struct MeshConfig {
  LabelMeshSettings labels;
  SurfaceMeshSettings surface;
  bool as_it_is = false;  ///< A surface of a size that no body has is not refused.
  std::optional<CondenseSettings> condense;  ///< Only if requested: see RequestCondensation.
};

/// @param document  Of format acus-mesh/1, checked and with defaults (config::ReadConfig).
MeshConfig MeshConfigFromJson(const nlohmann::json& document);

/// Sets the corridor's ends; without one in the config it gets the schema's radius and size.
void SetCorridor(MeshConfig& config, const std::string& from, const std::string& to);
/// From the points entry and target of a file, such as corridor_ct.csv of acus-phantom; CT space.
/// @throws InputError as transforms::ReadLandmarks, or if a point is missing.
void SetCorridorOfFile(MeshConfig& config, const std::filesystem::path& file);

/// Sets config.condense from the document that `config` was made from; as CondenseSettingsFromJson.
/// @throws InputError also if there is no corridor.
void RequestCondensation(MeshConfig& config, const nlohmann::json& document,
                         const std::filesystem::path& relative_to, const std::string& probe_at);

}  // namespace acus::meshing
