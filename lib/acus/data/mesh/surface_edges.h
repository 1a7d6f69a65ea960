// The edges of a triangle surface and the triangles at them.
#pragma once

#include <algorithm>
#include <vector>

#include "acus/data/mesh/surface.h"

namespace acus::mesh {

/// One side of a triangle, running from -> to.
struct HalfEdge {
  int low, high;  ///< The nodes, smaller number first.
  int triangle;
  bool is_forward;  ///< The triangle runs from low to high.

  bool IsSameEdge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

/// All sides of all triangles, those of one edge beside each other, in order of triangle.
inline std::vector<HalfEdge> SortedHalfEdges(const Eigen::Matrix3Xi& triangles) {
  std::vector<HalfEdge> out;
  out.reserve(3 * static_cast<std::size_t>(triangles.cols()));
  for (int t = 0; t < triangles.cols(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const int from = triangles(c, t);
      const int to = triangles((c + 1) % 3, t);
      out.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  std::ranges::sort(out, [](const HalfEdge& a, const HalfEdge& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return out;
}

/// Calls visit(first, count) for each edge, with its half-edges beside each other.
template <typename Visit>
void ForEachEdge(const std::vector<HalfEdge>& sorted, const Visit& visit) {
  for (std::size_t begin = 0; begin < sorted.size();) {
    std::size_t end = begin + 1;
    while (end < sorted.size() && sorted[end].IsSameEdge(sorted[begin])) ++end;
    visit(&sorted[begin], end - begin);
    begin = end;
  }
}

/// Sets of things that are found to belong together.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<int>(i);
  }
  int Find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(int a, int b) {
    const auto [low, high] = std::minmax({Find(a), Find(b)});
    parent_[high] = low;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace acus::mesh
