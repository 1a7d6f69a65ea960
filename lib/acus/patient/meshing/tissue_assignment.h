// Which tissue each tetrahedron is of, so that the tissues' volumes are those of the label map.
#pragma once

#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/patient/meshing/material_field.h"

namespace acus::meshing {

/// Sets mesh.tissue. On entry it holds each tetrahedron's material; the label is chosen among the
/// labels of that material by the share of the tetrahedron that each fills (sampled at 35 points),
/// plus a bonus per label that is raised until its total volume fits: layers thinner than the
/// elements (skin) then keep their volume where plain majority would lose them.
/// @param nodes_in_grid_mm  The nodes in the grid frame of material_field.h.
void AssignTissues(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
                   const Eigen::Matrix3Xd& nodes_in_grid_mm, int num_threads,
                   mesh::TetraMesh& mesh);

}  // namespace acus::meshing
