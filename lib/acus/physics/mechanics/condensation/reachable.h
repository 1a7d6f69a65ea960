// Which nodes of a mesh tools can reach, and which of them an image shows.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"

namespace acus::mechanics {

/// All places within `radius_mm` of a straight line. CT space, LPS.
struct Capsule {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// The outer surface within `radius_mm` of a place. CT space, LPS.
struct SkinPatch {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// All nodes that can move of every tetrahedron that has a point in common with the capsule: a
/// needle in it is then inside elements that are reachable as a whole (except for fixed nodes).
/// @returns mesh nodes, ascending.
/// @throws InputError if there is none, with the capsule and the mesh's bounds.
std::vector<int> CorridorNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                               const Capsule& corridor);

/// The nodes of the outer surface that can move and are in the patch: what a probe can press.
/// @returns mesh nodes, ascending.
/// @throws InputError if there is none, with the distance to the nearest.
std::vector<int> SkinNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                           const SkinPatch& patch);

/// Nodes in the capsule that can move, ascending; may be none.
std::vector<int> NodesInside(const mesh::TetraMesh& mesh, const FreeNodes& free,
                             const Capsule& capsule);

/// Where a needle in the corridor acts on the tissue: CorridorNodes, and within `beyond_mm` of the
/// corridor enough nodes for the mean of a smooth displacement over the ball of a tip's force,
/// at least kSparseSpacingMm apart (those of the outer surface among themselves), whatever the
/// mesh. Which ones depends on places, not on numbers.
/// @returns mesh nodes, ascending. @throws InputError as CorridorNodes.
inline constexpr double kSparseSpacingMm = 5.0;
std::vector<int> NeedleNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                             const Capsule& corridor, double beyond_mm);

/// The nodes of both lists, ascending, each once.
std::vector<int> Joined(const std::vector<int>& a, const std::vector<int>& b);

}  // namespace acus::mechanics
