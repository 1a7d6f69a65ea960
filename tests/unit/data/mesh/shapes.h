// Surfaces and meshes with known truth, for the tests of this folder.
#pragma once
#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "support/icosphere.h"

namespace acus::mesh::shapes {

/// Cube [0, edge]^3 of 12 triangles, outwards.
inline Surface Cube(double edge = 1.0, Eigen::Vector3d corner = Eigen::Vector3d::Zero()) {
  Surface out;
  out.nodes_mm.resize(3, 8);
  for (int n = 0; n < 8; ++n) {
    out.nodes_mm.col(n) = corner + edge * Eigen::Vector3d(n & 1, (n >> 1) & 1, (n >> 2) & 1);
  }
  out.triangles.resize(3, 12);
  out.triangles.transpose() << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7,
      3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  return out;
}

using testing_support::Icosphere;
using testing_support::Joined;

/// Two tetrahedra that share a face; tissues 3 and 5; node 4 fixed.
inline TetraMesh TwoTetrahedra() {
  TetraMesh out;
  out.nodes_mm.resize(3, 5);
  out.nodes_mm.transpose() << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  out.tetrahedra.resize(4, 2);
  out.tetrahedra.transpose() << 0, 1, 2, 3, 1, 2, 3, 4;
  out.tissue = {3, 5};
  out.fixed_nodes = {0, 0, 0, 0, 1};
  return out;
}

}  // namespace acus::mesh::shapes
