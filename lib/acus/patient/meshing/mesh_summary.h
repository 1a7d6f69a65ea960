// What a mesh has become, in a few lines for people, and a warning if nothing holds it.
#pragma once

#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/meshing/label_mesher.h"

namespace acus::meshing {

/// Voxels of the label map that the mesh does not follow.
struct MeshLosses {
  double islands_ml = 0.0;  ///< Loose pieces of the body.
  double specks_ml = 0.0;   ///< Smaller than the elements.
};

/// Nodes, tetrahedra, smallest angle, fixed nodes by tissue, tissues and what is missing.
/// @param tissues  Those of the label map; may be empty if they are not known.
/// @param fixed_tissues  Names, as configured.
std::string MeshText(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                     const std::vector<std::string>& fixed_tissues, const MeshLosses& losses);

/// Warns if no node is fixed: no tissue can deform on such a mesh. Says what to try.
void WarnWithoutFixedNodes(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                           const std::vector<std::string>& fixed_tissues,
                           const RunContext& context);

}  // namespace acus::meshing
