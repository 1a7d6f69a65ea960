// Tetrahedral meshes of tissue.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

namespace acus::mesh {

struct TetraMesh {
  Eigen::Matrix3Xd nodes_mm;              ///< 3 x n, LPS.
  Eigen::Matrix4Xi tetrahedra;            ///< 4 x m, node numbers, positive volume.
  std::vector<std::uint8_t> tissue;       ///< m labels, see volume/labels.h; empty: not known.
  std::vector<std::uint8_t> fixed_nodes;  ///< n flags: 1 = held in place (bone).
};

}  // namespace acus::mesh
