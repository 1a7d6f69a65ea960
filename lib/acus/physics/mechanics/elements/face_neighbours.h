// Which tetrahedra share a face. Private to this module.
#pragma once

#include <Eigen/Core>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mechanics {

/// 4 x m: the tetrahedron behind the face opposite to each corner; -1: none. Where more than two
/// share a face, which no proper mesh has, they are paired by number.
Eigen::Matrix4Xi FaceNeighbours(const mesh::TetraMesh& mesh);

}  // namespace acus::mechanics
