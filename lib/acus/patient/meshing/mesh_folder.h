// The output folder of acus-mesh.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/meshing/mesh_config.h"

namespace acus::meshing {

/// Reads a label map, meshes it and writes mesh.vtu, quality.json, quality.svg and provenance.json;
/// with config.condense also compliance.acc and condensation.json.
/// The folder appears whole or not at all. Warns if no node is fixed. Returns a summary for people.
/// @throws as MeshLabelMap and WriteCondensed, and InputError if a file cannot be read or written.
std::string MeshLabelsToFolder(const std::filesystem::path& labels, const MeshConfig& config,
                               const std::filesystem::path& folder, const RunContext& context);

/// The same for a closed surface, filled with the standard tissue of that name.
/// @throws as MeshSurface, and InputError if there is no such tissue.
std::string MeshSurfaceToFolder(const std::filesystem::path& surface, const std::string& tissue,
                                const MeshConfig& config, const std::filesystem::path& folder,
                                const RunContext& context);

/// Condenses a mesh that is there already; the folder gets a copy of it, so that both stay
/// together.
/// @pre RequestCondensation was called.
/// @throws as WriteCondensed, and InputError if the mesh cannot be read or has no tissue ids.
std::string CondenseMeshToFolder(const std::filesystem::path& mesh, const MeshConfig& config,
                                 const std::filesystem::path& folder, const RunContext& context);

}  // namespace acus::meshing
