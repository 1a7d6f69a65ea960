// A surface that breath has moved, where tools press it besides.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/imaging/volume_rendering/pressed_tissue.h"

namespace acus::volume_rendering {

/// A copy of nodes and normals in which those near a tool are moved on.
class PressedSurface {
 public:
  /// For a moment, whatever was before; the same bits with any number of threads.
  /// @param nodes_mm, normals, triangles  Moved by breath, CT space. Must outlive the next call.
  void Update(const PressedTissue& pressed, const Eigen::Matrix3Xf& nodes_mm,
              const Eigen::Matrix3Xf& normals, const Eigen::Matrix3Xi& triangles, int num_threads);

  const Eigen::Matrix3Xf& nodes_mm() const { return nodes_mm_; }
  const Eigen::Matrix3Xf& normals() const { return normals_; }
  /// Nodes of the last update that a tool has moved.
  int num_pressed() const { return num_pressed_; }

 private:
  void RenewNormals(const Eigen::Matrix3Xi& triangles);

  Eigen::Matrix3Xf nodes_mm_;
  Eigen::Matrix3Xf normals_;
  std::vector<std::uint8_t> touched_;  ///< By node: 1 moved, 2 its normal turns.
  int num_pressed_ = 0;
};

}  // namespace acus::volume_rendering
