// Surfaces and meshes with known truth, for the tests of this folder.
#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "acus/data/mesh/surface.h"
#include "acus/data/mesh/tetra_mesh.h"

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

/// Sphere by `splits` subdivisions of an icosahedron: 20 * 4^splits triangles, outwards.
inline Surface Sphere(double radius_mm, int splits,
                      Eigen::Vector3d centre = Eigen::Vector3d::Zero()) {
  const double g = std::numbers::phi;
  std::vector<Eigen::Vector3d> nodes = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                        {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                        {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Eigen::Vector3i> faces = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int s = 0; s < splits; ++s) {
    std::map<std::pair<int, int>, int> middle;
    const auto split = [&](int a, int b) {
      const auto [entry, is_new] =
          middle.try_emplace(std::minmax(a, b), static_cast<int>(nodes.size()));
      if (is_new) nodes.push_back(nodes[a] + nodes[b]);
      return entry->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (auto& n : nodes) n.normalize();
    for (const auto& f : faces) {
      const int ab = split(f[0], f[1]), bc = split(f[1], f[2]), ca = split(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {f[1], bc, ab}, {f[2], ca, bc}, {ab, bc, ca}});
    }
    faces = finer;
  }
  Surface out;
  out.nodes_mm.resize(3, static_cast<Eigen::Index>(nodes.size()));
  out.triangles.resize(3, static_cast<Eigen::Index>(faces.size()));
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    out.nodes_mm.col(static_cast<Eigen::Index>(n)) = centre + radius_mm * nodes[n].normalized();
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    out.triangles.col(static_cast<Eigen::Index>(f)) = faces[f];
  }
  return out;
}

/// Two surfaces in one.
inline Surface Joined(const Surface& a, const Surface& b) {
  Surface out;
  out.nodes_mm.resize(3, a.nodes_mm.cols() + b.nodes_mm.cols());
  out.nodes_mm << a.nodes_mm, b.nodes_mm;
  out.triangles.resize(3, a.triangles.cols() + b.triangles.cols());
  out.triangles << a.triangles,
      (b.triangles.array() + static_cast<int>(a.nodes_mm.cols())).matrix();
  return out;
}

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
