// Where interfaces are too bent, or too close to each other, for elements of a size.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "acus/patient/meshing/material_field.h"

namespace acus::meshing {

/// Blocks of an octree: level 0 is finest, a block of level k is 2^k finest blocks wide.
struct BlockGrid {
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();  ///< Low corner of block (0, 0, 0).
  double finest_mm = 1.0;
  int top = 0;                                         ///< Coarsest level.
  Eigen::Vector3i top_size = Eigen::Vector3i::Zero();  ///< Blocks of that level.

  Eigen::Vector3i Size(int level) const { return top_size * (1 << (top - level)); }
  std::size_t Index(int level, const Eigen::Vector3i& b) const {
    const Eigen::Vector3i size = Size(level);
    return (static_cast<std::size_t>(b[2]) * size[1] + b[1]) * size[0] + b[0];
  }
};

/// For each block, how far its pieces of interface are from planes: for each two materials that
/// touch in it, the root mean square distance of the faces between their voxels from the plane that
/// fits them best. Curvature raises it, and so do two sheets of one interface (a vessel, a wall)
/// that a block of that size holds together: what elements of its size cannot follow.
class InterfaceShape {
 public:
  /// @param unit_mm  Distances are in these units, axis by axis: the label map's spacing.
  InterfaceShape(const MaterialField& field, const BlockGrid& grid, const Eigen::Array3d& unit_mm);

  /// Largest over the pairs of materials; 0 where there is no interface.
  double Roughness(int level, std::size_t block) const { return roughness_[level][block]; }

 private:
  std::vector<std::vector<float>> roughness_;  ///< By level, then block.
};

}  // namespace acus::meshing
