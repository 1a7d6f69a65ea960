// A block that is held below, a rotation by 120 degrees and displacements at random.
#pragma once

#include <Eigen/Geometry>

#include "acus/base/core/random.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::testing_support {

inline mesh::TetraMesh Block() {
  mesh::TetraMesh box = BoxMesh({3, 3, 4}, {0, 0, 0}, {30, 30, 40}, 0.15);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return box;
}

inline Eigen::Matrix3d Turn() {
  return Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
}

/// Displacements of up to `size_mm` at random, of all nodes.
inline Eigen::Matrix3Xd SomeDisplacements(const mesh::TetraMesh& mesh, double size_mm) {
  RandomStream random(7, "displacements");
  Eigen::Matrix3Xd u(3, mesh.nodes_mm.cols());
  for (double& value : u.reshaped()) value = size_mm * random.Uniform(-1.0, 1.0);
  return u;
}

}  // namespace acus::testing_support
