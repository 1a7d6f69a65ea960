#include "acus/patient/meshing/mesh_limits.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/surface_groups.h"

namespace acus::meshing {
namespace {

bool MissesVolume(double mesh_ml, double map_ml, const LabelMeshSettings& settings) {
  return std::abs(mesh_ml - map_ml) > settings.volume_tolerance * map_ml;
}

}  // namespace

std::string Shortfall(const LabelMesh& mesh, const LabelMeshSettings& settings) {
  const mesh::QualityReport quality = mesh::MeasureQuality(mesh.mesh);
  if (quality.num_inverted > 0 || quality.min_dihedral_deg < settings.min_dihedral_deg) {
    const Eigen::Vector3d& at = quality.worst_at_mm;
    return Message("the smallest dihedral angle is ", quality.min_dihedral_deg, " degrees at (",
                   at[0], ", ", at[1], ", ", at[2], ") mm; required: ", settings.min_dihedral_deg);
  }
  if (MissesVolume(mesh.body_mesh_ml, mesh.body_target_ml, settings)) {
    return Message("the body has ", mesh.body_mesh_ml, " ml in the mesh and ", mesh.body_target_ml,
                   " ml in the label map without loose islands");
  }
  for (const TissueVolume& tissue : mesh.tissues) {
    if (tissue.is_conforming && MissesVolume(tissue.mesh_ml, tissue.target_ml, settings)) {
      return Message(tissue.name, " has ", tissue.mesh_ml, " ml in the mesh and ", tissue.target_ml,
                     " ml in the label map");
    }
  }
  return {};
}

std::string GiveUpThinTissues(const LabelMesh& mesh, double factor, LabelMeshSettings& settings) {
  const auto largest = std::ranges::max_element(mesh.tissues, {}, &TissueVolume::map_ml);
  LabelMeshSettings wide = settings;
  wide.volume_tolerance *= factor;
  std::string names;
  for (const TissueVolume& tissue : mesh.tissues) {
    if (!tissue.is_conforming || (AllConform(settings) && tissue.label == largest->label) ||
        !MissesVolume(tissue.mesh_ml, tissue.target_ml, wide)) {
      continue;
    }
    settings.except_tissues.push_back(tissue.name);
    names += (names.empty() ? "" : ", ") + tissue.name;
  }
  return names;
}

}  // namespace acus::meshing
