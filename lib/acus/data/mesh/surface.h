// Triangle surfaces.
#pragma once

#include <Eigen/Dense>

namespace acus::mesh {

struct Surface {
  Eigen::Matrix3Xd nodes_mm;   ///< 3 x n, LPS.
  Eigen::Matrix3Xi triangles;  ///< 3 x m, node numbers, counter-clockwise seen from outside.
};

/// The volume enclosed by a closed surface; negative if its triangles face inwards.
double SignedVolumeMm3(const Surface& surface);

/// Without the nodes that no triangle uses.
Surface WithoutUnusedNodes(const Surface& surface);

}  // namespace acus::mesh
