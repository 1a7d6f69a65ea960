// Surfaces of a patient, moved by breath.
#pragma once

#include <Eigen/Dense>

#include "acus/data/mesh/surface.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

/// world_mm.col(i) = rest_mm.col(i) + u(rest_mm.col(i), t), in single precision; the same bits with
/// any number of threads. @param motion  Null: a copy.
/// @pre Both have the same size.
void DisplaceVertices(const breathing::MotionMap* motion, const Eigen::Matrix3Xf& rest_mm,
                      Eigen::Matrix3Xf& world_mm, int num_threads);

/// A triangle surface with a normal for each vertex: at rest the mean of its triangles' by their
/// areas; moved, that one turned by the gradient of the motion.
class MovingSurface {
 public:
  /// @throws InputError if the surface has no triangle, a triangle names a node that is not there,
  ///     or a place is not finite.
  explicit MovingSurface(const mesh::Surface& surface);

  /// To a moment. Costs nothing where it is there already: at rest. Allocates nothing.
  /// @param motion  Null or still: at rest.
  void Update(const breathing::MotionMap* motion, int num_threads);

  const Eigen::Matrix3Xf& nodes_mm() const { return world_mm_; }
  const Eigen::Matrix3Xf& normals() const { return normals_; }
  const Eigen::Matrix3Xi& triangles() const { return triangles_; }
  Eigen::AlignedBox3d RestBox() const;

 private:
  void SetRestNormals();

  Eigen::Matrix3Xf rest_mm_;
  Eigen::Matrix3Xi triangles_;
  Eigen::Matrix3Xf rest_normals_;
  Eigen::Matrix3Xf world_mm_;
  Eigen::Matrix3Xf normals_;
  bool at_rest_ = false;
};

}  // namespace acus::volume_rendering
