#include "acus/patient/meshing/mesh_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/meshing/mesh_report.h"
#include "acus/patient/meshing/mesh_summary.h"

namespace acus::meshing {
namespace {

using nlohmann::json;

/// Condenses the mesh if that was requested.
void FinishFolder(AtomicFolder& folder, const mesh::TetraMesh& mesh, const MeshConfig& config,
                  const RunContext& context) {
  if (config.condense) {
    WriteCondensed(folder.path(), mesh, *config.labels.sizes.corridor, *config.condense, context);
  }
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
}

/// Returns the summary.
std::string WriteFolder(const std::filesystem::path& target, const mesh::TetraMesh& mesh,
                        const std::vector<TissueVolume>& tissues, const Eigen::Vector3d& centre_mm,
                        double min_dihedral_deg, const json& about, const MeshLosses& losses,
                        const MeshConfig& config, const RunContext& context) {
  // Condensing refuses such a mesh.
  if (!config.condense) WarnWithoutFixedNodes(mesh, tissues, config.labels.fixed_tissues, context);
  context.Checkpoint("writing the mesh", 0.9);
  AtomicFolder folder(target, context.overwrite);
  mesh::WriteTetraMesh(folder.path() / "mesh.vtu", mesh);
  json quality = DescribeMesh(mesh, tissues);
  quality["format"] = "acus-mesh-quality/1";
  quality["min_dihedral_limit_deg"] = min_dihedral_deg;
  quality.update(about);
  config::WriteJson(folder.path() / "quality.json", quality);
  WriteTextFile(folder.path() / "quality.svg",
                MeshImageSvg(mesh, tissues, centre_mm, min_dihedral_deg));
  FinishFolder(folder, mesh, config, context);
  return MeshText(mesh, tissues, config.labels.fixed_tissues, losses);
}

}  // namespace

std::string MeshLabelsToFolder(const std::filesystem::path& labels, const MeshConfig& config,
                               const std::filesystem::path& folder, const RunContext& context) {
  context.Checkpoint("reading labels", 0.0);
  const volume::LabelMap map = volume::ReadLabelMap(labels);
  LabelMesh out = MeshLabelMap(map, config.labels, context);
  context.Checkpoint("measuring the mesh", 0.8);
  AddSurfaceDistances(map, context.num_threads, out);
  const auto& corridor = config.labels.sizes.corridor;
  const json about = {{"body",
                       {{"label_map_ml", out.body_map_ml},
                        {"mesh_ml", out.body_mesh_ml},
                        {"surface_distance", ToJson(*out.body_surface)}}},
                      {"dropped_islands_ml", out.dropped_ml},
                      {"dropped_specks_ml", out.specks_ml},
                      {"element_size_mm",
                       {{"interface", out.sizes.interface_mm},
                        {"skin", out.sizes.skin_mm},
                        {"interior", out.sizes.interior_mm}}}};
  const Eigen::Vector3d centre_mm =
      corridor ? Eigen::Vector3d(0.5 * (corridor->from_mm + corridor->to_mm)) : CentreOf(out.mesh);
  return WriteFolder(folder, out.mesh, out.tissues, centre_mm, config.labels.min_dihedral_deg,
                     about, {.islands_ml = out.dropped_ml, .specks_ml = out.specks_ml}, config,
                     context);
}

std::string MeshSurfaceToFolder(const std::filesystem::path& surface, const std::string& tissue,
                                const MeshConfig& config, const std::filesystem::path& folder,
                                const RunContext& context) {
  SurfaceMeshSettings settings = config.surface;
  settings.tissue = volume::LabelOf(tissue);
  ACUS_REQUIRE(settings.tissue != 0, "'", tissue,
               "' is not a tissue; name what the surface encloses");
  settings.is_fixed = std::ranges::count(config.labels.fixed_tissues, tissue) > 0;
  const mesh::Surface content = mesh::ReadSurface(surface);
  if (!config.as_it_is) mesh::RequireSizeOfBody(content, surface);
  const SurfaceMesh out = MeshSurface(content, surface.string(), settings, context);
  const std::vector<TissueVolume> tissues = {{.label = settings.tissue,
                                              .name = tissue,
                                              .map_ml = out.surface_ml,
                                              .target_ml = out.surface_ml,
                                              .mesh_ml = out.mesh_ml,
                                              .is_conforming = !out.is_remeshed}};
  const json about = {{"repairs", out.repairs}, {"surface_was_made_anew", out.is_remeshed}};
  return WriteFolder(folder, out.mesh, tissues, CentreOf(out.mesh), settings.min_dihedral_deg,
                     about, {}, config, context);
}

std::string CondenseMeshToFolder(const std::filesystem::path& mesh, const MeshConfig& config,
                                 const std::filesystem::path& folder, const RunContext& context) {
  ACUS_ASSERT(config.condense && config.labels.sizes.corridor);
  context.Checkpoint("reading the mesh", 0.0);
  const mesh::TetraMesh content = mesh::ReadTetraMesh(mesh);
  ACUS_REQUIRE(!content.tissue.empty(), mesh.string(),
               ": has no tissue ids (cell data \"tissue\"), so that its stiffness is not known; "
               "mesh the label map with acus-mesh");
  AtomicFolder out(folder, context.overwrite);
  mesh::WriteTetraMesh(out.path() / "mesh.vtu", content);
  FinishFolder(out, content, config, context);
  return MeshText(content, {}, config.labels.fixed_tissues, {});
}

}  // namespace acus::meshing
