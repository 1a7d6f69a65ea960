// What a mesh is like: numbers for quality.json, and an image.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/label_mesher.h"

namespace acus::meshing {

/// Counts, angles, histogram, and per tissue its volumes, their difference and the element count.
nlohmann::json DescribeMesh(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues);

/// {p95_mm, p95_voxels, mean_mm, samples}; null for a distance to what is not there.
nlohmann::json ToJson(const SurfaceDistance& distance);

/// SVG: two cuts through the mesh at `centre_mm` (axial, sagittal) coloured by tissue, a histogram
/// of the dihedral angles with the limit, and a table of volumes.
std::string MeshImageSvg(const mesh::TetraMesh& mesh, const std::vector<TissueVolume>& tissues,
                         const Eigen::Vector3d& centre_mm, double min_dihedral_deg);

/// The centre of the mesh's bounding box.
Eigen::Vector3d CentreOf(const mesh::TetraMesh& mesh);

}  // namespace acus::meshing
