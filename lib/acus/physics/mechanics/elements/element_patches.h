// The tetrahedra that resist deformation, in the groups that change their volume together. Private
// to this module.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::mechanics {

struct ElementPatch {
  std::vector<int> tetrahedra;  ///< Of one tissue.
  std::vector<int> nodes;       ///< Of these, ascending, each once.
};

/// One patch per tetrahedron for linear elements. Tetrahedra that are omitted or have four fixed
/// nodes are in none. @param is_left_out  Flag per tetrahedron; empty: none.
std::vector<ElementPatch> ElementPatches(const mesh::TetraMesh& mesh, ElementKind kind,
                                         std::span<const std::uint8_t> is_left_out);

}  // namespace acus::mechanics
