// A bounding volume hierarchy over the triangles of several surfaces: which of them a segment may
// meet. All that is known of Embree stays behind this header.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "acus/imaging/slicing/tracing/exact_crossing.h"

namespace acus::tracing {

/// Nodes in whole units, 3 x n.
using NodeMatrix = Eigen::Matrix<std::int32_t, 3, Eigen::Dynamic>;

struct TreeSurface {
  NodeMatrix nodes;  ///< Within kMaxNode / 2.
  Eigen::Matrix3Xi triangles;

  Place NodeOf(Eigen::Index triangle, int corner) const {
    const auto node = nodes.col(triangles(corner, triangle));
    return {node[0], node[1], node[2]};
  }
};

/// Immutable: any number of threads may search at a time.
class TriangleTree {
 public:
  /// Called for each triangle whose box the segment meets, in any order.
  using Visit = void (*)(void* context, std::uint32_t surface, std::uint32_t triangle);

  /// @throws InputError if there is no triangle, or not enough memory for the hierarchy.
  /// @param num_threads  That build it. What Search visits does not depend on it.
  TriangleTree(std::vector<TreeSurface> surfaces, int num_threads);
  ~TriangleTree();
  TriangleTree(const TriangleTree&) = delete;
  TriangleTree& operator=(const TriangleTree&) = delete;

  /// Visits every triangle that the segment meets, and others nearby. Allocates nothing.
  /// @pre coordinates are within kMaxPlace.
  void Search(const Place& from, const Place& to, Visit visit, void* context) const noexcept;

  const std::vector<TreeSurface>& surfaces() const { return surfaces_; }
  /// Whether the place lies outside of the box around all triangles.
  bool IsOutside(const Place& place) const noexcept;
  std::size_t num_triangles() const;
  std::size_t memory_bytes() const;  ///< Of nodes, triangles and hierarchy.

 private:
  struct Embree;
  std::vector<TreeSurface> surfaces_;
  std::array<double, 3> low_{};   ///< Of the box around all triangles, somewhat larger.
  std::array<double, 3> high_{};  ///< The same.
  std::unique_ptr<Embree> embree_;
};

}  // namespace acus::tracing
