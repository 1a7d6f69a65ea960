// Which nodes of a mesh can move, and which parts of it nothing holds.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mechanics {

/// Tetrahedra joined by faces that hang on nothing, or on one or two nodes or a straight line of
/// them, about which they would turn freely.
struct LoosePiece {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< LPS.
  double volume_mm3 = 0.0;
  int num_tetrahedra = 0;
};

/// The nodes that move. Degrees of freedom of an elastic system are 3 r + axis, with r the row of a
/// free node.
struct FreeNodes {
  std::vector<int> mesh_node;             ///< Of each row, ascending.
  std::vector<int> row_of_node;           ///< Of each mesh node; -1: it is held.
  std::vector<std::uint8_t> is_left_out;  ///< Of each tetrahedron: part of a loose piece.
  std::vector<LoosePiece> loose;          ///< Omitted; largest first. For a warning to the user.
  int num_dofs() const { return 3 * static_cast<int>(mesh_node.size()); }
};

/// Loose pieces up to this share of the volume, all together, are omitted; more is an error.
inline constexpr double kLargestLooseShare = 0.01;

/// Finds the nodes of supported tetrahedra that are not fixed. Loose pieces are omitted: their
/// tetrahedra resist nothing, and those of their nodes that belong to nothing else stay in place,
/// as do nodes without tetrahedra.
/// @throws InputError if no node is fixed; if loose pieces make up more than kLargestLooseShare
///     (with place and size of the largest); if no node is free; if an array of the mesh has the
///     wrong size or a node number is out of range.
FreeNodes FindFreeNodes(const mesh::TetraMesh& mesh);

}  // namespace acus::mechanics
