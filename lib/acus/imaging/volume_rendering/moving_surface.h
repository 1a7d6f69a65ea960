// Surfaces of a patient, moved by breath.
#pragma once

#include <Eigen/Dense>
#include <cstdint>

#include "acus/data/mesh/surface.h"
#include "acus/physics/breathing/attached_points.h"

namespace acus::volume_rendering {

/// A triangle surface with a normal for each vertex: at rest the mean of its triangles' by their
/// areas; moved, that one turned by the gradient of the motion.
class MovingSurface {
 public:
  /// @throws InputError if the surface has no triangle, a triangle names a node that is not there,
  ///     or a place is not finite.
  explicit MovingSurface(const mesh::Surface& surface);

  /// To a moment. Costs nothing where it is there already: at rest, or while the breath is held.
  /// @param motion  Null or still: at rest.
  void Update(const breathing::MotionMap* motion, int num_threads);

  const Eigen::Matrix3Xf& nodes_mm() const { return world_mm_; }
  const Eigen::Matrix3Xf& normals() const { return normals_; }
  const Eigen::Matrix3Xf& rest_mm() const { return nodes_.rest_mm(); }
  const Eigen::Matrix3Xf& rest_normals() const { return nodes_.rest_normals(); }
  const Eigen::Matrix3Xi& triangles() const { return triangles_; }
  Eigen::AlignedBox3d RestBox() const;

 private:
  bool IsAt(const breathing::MotionMap* motion) const;

  breathing::AttachedPoints nodes_;
  Eigen::Matrix3Xi triangles_;
  Eigen::Matrix3Xf world_mm_;
  Eigen::Matrix3Xf normals_;
  std::uint64_t field_ = 0;  ///< Of the instant that is shown; 0: at rest.
  breathing::MotionWeights weights_;
};

}  // namespace acus::volume_rendering
