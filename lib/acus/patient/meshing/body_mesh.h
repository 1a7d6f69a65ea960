// The body in a division of space: what is not outside.
#pragma once

#include <Eigen/Core>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/meshing/tetra_editor.h"

namespace acus::meshing {

/// Nodes of tetrahedra that are not outside (material 0).
std::size_t NumBodyNodes(const TetraEditor& editor);

/// Empties the pieces of the body that are small and touch the rest with no face.
/// @param min_share  Of the body's volume; smaller pieces become outside.
/// @return  what was emptied, ml. @throws InputError if there is no body.
double DropIslands(double min_share, TetraEditor& editor);

/// The body as a mesh; `tissue` is the material.
/// @param geometry  The editor's nodes are along its axes, mm from its origin.
/// @param in_grid_mm  3 x N: the nodes as the editor has them.
mesh::TetraMesh BodyOf(const TetraEditor& editor, const volume::Geometry& geometry,
                       Eigen::Matrix3Xd& in_grid_mm);

}  // namespace acus::meshing
