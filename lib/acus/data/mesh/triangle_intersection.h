// Whether triangles cut each other.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <utility>
#include <vector>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Whether two triangles have a point in common. Exactly touching counts.
bool TrianglesIntersect(const Triangle& a, const Triangle& b);

/// Pairs of triangles that have more in common than their shared nodes, in order; at most `limit`.
std::vector<std::pair<int, int>> IntersectingPairs(const Surface& surface, std::size_t limit);

}  // namespace acus::mesh
