// Boxes of tetrahedra to test mechanics on.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/data/mesh/tetra_mesh.h"

namespace acus::testing_support {

/// A box from `low_mm` to `high_mm` of cells x 6 tetrahedra, all of tissue 4 (soft_tissue), nothing
/// fixed. Inner nodes are moved by up to `jitter` of a cell along each axis (below 0.2: no
/// tetrahedron turns inside out).
inline mesh::TetraMesh BoxMesh(const Eigen::Vector3i& cells, const Eigen::Vector3d& low_mm,
                               const Eigen::Vector3d& high_mm, double jitter = 0.0,
                               std::uint64_t seed = 1) {
  mesh::TetraMesh box;
  const Eigen::Vector3i n = cells.array() + 1;
  const Eigen::Vector3d step = (high_mm - low_mm).array() / cells.cast<double>().array();
  const auto number = [&](int i, int j, int k) { return (k * n.y() + j) * n.x() + i; };
  RandomStream random(seed, "box mesh");
  box.nodes_mm.resize(3, n.prod());
  for (int k = 0; k < n.z(); ++k) {
    for (int j = 0; j < n.y(); ++j) {
      for (int i = 0; i < n.x(); ++i) {
        const Eigen::Vector3i at(i, j, k);
        Eigen::Vector3d place = at.cast<double>();
        for (int axis = 0; axis < 3; ++axis) {
          const double shift = jitter * (2.0 * random.Uniform() - 1.0);
          const bool is_inner = (at.array() > 0).all() && (at.array() < cells.array()).all();
          if (is_inner) place[axis] += shift;
        }
        box.nodes_mm.col(number(i, j, k)) = low_mm + place.cwiseProduct(step);
      }
    }
  }
  std::vector<Eigen::Vector4i> tetrahedra;
  for (int k = 0; k < cells.z(); ++k) {
    for (int j = 0; j < cells.y(); ++j) {
      for (int i = 0; i < cells.x(); ++i) {
        std::array<int, 3> axes{0, 1, 2};
        do {
          // From corner 000 to corner 111 along the axes in this order: six ways, six tetrahedra.
          Eigen::Vector3i at(i, j, k);
          Eigen::Vector4i t;
          t[0] = number(at.x(), at.y(), at.z());
          for (int c = 0; c < 3; ++c) {
            ++at[axes[c]];
            t[c + 1] = number(at.x(), at.y(), at.z());
          }
          const int inversions = (axes[0] > axes[1]) + (axes[0] > axes[2]) + (axes[1] > axes[2]);
          if (inversions % 2 == 1) std::swap(t[2], t[3]);
          tetrahedra.push_back(t);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  box.tetrahedra.resize(4, static_cast<Eigen::Index>(tetrahedra.size()));
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    box.tetrahedra.col(static_cast<Eigen::Index>(t)) = tetrahedra[t];
  }
  box.tissue.assign(tetrahedra.size(), 4);
  box.fixed_nodes.assign(static_cast<std::size_t>(n.prod()), 0);
  return box;
}

/// Fixes the nodes for which `is_held` is true of their place.
inline void Fix(mesh::TetraMesh& mesh, const std::function<bool(const Eigen::Vector3d&)>& is_held) {
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    mesh.fixed_nodes[static_cast<std::size_t>(i)] = is_held(mesh.nodes_mm.col(i));
  }
}

struct RenumberedMesh {
  mesh::TetraMesh mesh;
  std::vector<int> old_node;         ///< Of each new node.
  std::vector<int> old_tetrahedron;  ///< Of each new tetrahedron.
};

/// The same mesh with nodes, tetrahedra and the corners of each in another order.
inline RenumberedMesh Renumbered(const mesh::TetraMesh& mesh, std::uint64_t seed) {
  RandomStream random(seed, "renumbered");
  const auto shuffled = [&](std::size_t size) {
    std::vector<int> order(size);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = size; i > 1; --i) {
      std::swap(order[i - 1],
                order[static_cast<std::size_t>(random.Uniform() * static_cast<double>(i))]);
    }
    return order;
  };
  RenumberedMesh out{mesh, shuffled(mesh.fixed_nodes.size()), shuffled(mesh.tissue.size())};
  std::vector<int> new_node(out.old_node.size());
  for (std::size_t i = 0; i < out.old_node.size(); ++i) {
    new_node[out.old_node[i]] = static_cast<int>(i);
    out.mesh.nodes_mm.col(static_cast<Eigen::Index>(i)) = mesh.nodes_mm.col(out.old_node[i]);
    out.mesh.fixed_nodes[i] = mesh.fixed_nodes[out.old_node[i]];
  }
  constexpr int kTurns[4][4] = {{0, 1, 2, 3}, {1, 2, 0, 3}, {3, 2, 1, 0}, {2, 3, 0, 1}};
  for (std::size_t t = 0; t < out.old_tetrahedron.size(); ++t) {
    out.mesh.tissue[t] = mesh.tissue[out.old_tetrahedron[t]];
    const auto& turn = kTurns[random.Next() % 4];
    for (int c = 0; c < 4; ++c) {
      out.mesh.tetrahedra(c, static_cast<Eigen::Index>(t)) =
          new_node[mesh.tetrahedra(turn[c], out.old_tetrahedron[t])];
    }
  }
  return out;
}

}  // namespace acus::testing_support
