// Balls of triangles.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "acus/data/mesh/surface.h"

namespace acus::testing_support {

/// An icosahedron's faces cut in four `levels` times, all nodes on the sphere: 20 * 4^levels
/// triangles.
inline mesh::Surface Icosphere(double radius_mm, int levels,
                               const Eigen::Vector3d& middle_mm = Eigen::Vector3d::Zero()) {
  const double p = std::numbers::phi;
  std::vector<Eigen::Vector3d> nodes = {{-1, p, 0}, {1, p, 0}, {-1, -p, 0}, {1, -p, 0},
                                        {0, -1, p}, {0, 1, p}, {0, -1, -p}, {0, 1, -p},
                                        {p, 0, -1}, {p, 0, 1}, {-p, 0, -1}, {-p, 0, 1}};
  std::vector<Eigen::Vector3i> faces = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [entry, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(nodes.size()));
      if (is_new) nodes.push_back((nodes[a].normalized() + nodes[b].normalized()).normalized());
      return entry->second;
    };
    std::vector<Eigen::Vector3i> finer;
    for (const auto& f : faces) {
      const int a = middle(f[0], f[1]), b = middle(f[1], f[2]), c = middle(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    faces = std::move(finer);
  }
  mesh::Surface out;
  out.nodes_mm.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    out.nodes_mm.col(static_cast<Eigen::Index>(n)) = middle_mm + radius_mm * nodes[n].normalized();
  }
  out.triangles.resize(3, static_cast<Eigen::Index>(faces.size()));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    out.triangles.col(static_cast<Eigen::Index>(f)) = faces[f];
  }
  return out;
}

/// Two surfaces in one.
inline mesh::Surface Joined(const mesh::Surface& a, const mesh::Surface& b) {
  mesh::Surface out;
  out.nodes_mm.resize(3, a.nodes_mm.cols() + b.nodes_mm.cols());
  out.nodes_mm << a.nodes_mm, b.nodes_mm;
  out.triangles.resize(3, a.triangles.cols() + b.triangles.cols());
  out.triangles << a.triangles,
      (b.triangles.array() + static_cast<int>(a.nodes_mm.cols())).matrix();
  return out;
}

}  // namespace acus::testing_support
