// Groups of tetrahedra that change their volume together.
#pragma once

#include <span>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mechanics {

/// Divides tetrahedra into patches of one tissue each, mostly all those around a node (about 20):
/// the sets over which an element of ElementKind::kAveragedDilatation averages its change of
/// volume.
///
/// Stars of nodes are packed as closely as they go, like an advancing front: next is always the
/// free star that has the largest share of its surface against what is taken. What remains over
/// joins a patch beside it. Choices depend on places of nodes and on how they are joined, never on
/// their numbers or on those of the tetrahedra; docs/models/tissue_elasticity.md says why patches
/// and why these.
/// @param tetrahedra  Numbers of those to divide, each once.
/// @return  Tetrahedra of each patch; each of `tetrahedra` is in exactly one.
std::vector<std::vector<int>> DilatationPatches(const mesh::TetraMesh& mesh,
                                                std::span<const int> tetrahedra);

}  // namespace acus::mechanics
