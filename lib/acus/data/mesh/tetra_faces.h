// The faces of tetrahedra.
#pragma once

#include <array>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

struct TetraFace {
  std::array<int, 3> nodes;  ///< Ascending.
  int tetrahedron;

  bool IsSameFace(const TetraFace& other) const { return nodes == other.nodes; }
};

/// The four faces of every tetrahedron; those of one place beside each other, in order of
/// tetrahedron.
std::vector<TetraFace> SortedFaces(const TetraMesh& mesh);

/// Flag per node: 1 on the outer surface, whose faces belong to one tetrahedron only.
std::vector<std::uint8_t> OuterNodes(const TetraMesh& mesh);

}  // namespace acus::mesh
