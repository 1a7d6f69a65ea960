#include "acus/data/mesh/triangle_intersection.h"

#include <algorithm>
#include <cmath>

namespace acus::mesh {
namespace {

/// Twice the signed area of abc seen along +axis.
double Area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            int axis) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
}

double Volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
              const Eigen::Vector3d& d) {
  return (b - a).dot((c - a).cross(d - a));
}

/// In one plane, seen along `axis`: whether the segments pq and ab have a point in common.
bool SegmentsMeet(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                  const Eigen::Vector3d& b, int axis) {
  const double p_side = Area(a, b, p, axis);
  const double q_side = Area(a, b, q, axis);
  const double a_side = Area(p, q, a, axis);
  const double b_side = Area(p, q, b, axis);
  if (p_side == 0 && q_side == 0) {  // In line: do the extents overlap?
    for (int d = 0; d < 3; ++d) {
      if (d != axis && (std::max(p[d], q[d]) < std::min(a[d], b[d]) ||
                        std::max(a[d], b[d]) < std::min(p[d], q[d]))) {
        return false;
      }
    }
    return true;
  }
  return p_side * q_side <= 0 && a_side * b_side <= 0;
}

bool IsInside(const Eigen::Vector3d& p, const Triangle& t, int axis) {
  const double a = Area(t[0], t[1], p, axis);
  const double b = Area(t[1], t[2], p, axis);
  const double c = Area(t[2], t[0], p, axis);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

int WidestAxis(const Triangle& t) {
  const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).cwiseAbs();
  int axis = 0;
  normal.maxCoeff(&axis);
  return axis;
}

/// Segment pq in the plane of t.
bool FlatSegmentMeets(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Triangle& t) {
  const int axis = WidestAxis(t);
  if (IsInside(p, t, axis) || IsInside(q, t, axis)) return true;
  return SegmentsMeet(p, q, t[0], t[1], axis) || SegmentsMeet(p, q, t[1], t[2], axis) ||
         SegmentsMeet(p, q, t[2], t[0], axis);
}

bool SegmentMeets(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Triangle& t) {
  const double p_side = Volume(t[0], t[1], t[2], p);
  const double q_side = Volume(t[0], t[1], t[2], q);
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) return FlatSegmentMeets(p, q, t);
  const double a = Volume(p, q, t[0], t[1]);
  const double b = Volume(p, q, t[1], t[2]);
  const double c = Volume(p, q, t[2], t[0]);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

/// Whether a and b, which share the nodes a[0..shared) = b[0..shared), meet anywhere else.
bool MeetBeyond(const Triangle& a, const Triangle& b, int shared) {
  if (shared == 0) return TrianglesIntersect(a, b);
  if (shared == 1) {  // Only the opposite edges can run into the other triangle.
    return SegmentMeets(a[1], a[2], b) || SegmentMeets(b[1], b[2], a);
  }
  // A common edge: they overlap only if folded onto each other, in one plane and on one side.
  const Eigen::Vector3d edge = a[1] - a[0];
  const Eigen::Vector3d na = edge.cross(a[2] - a[0]);
  const Eigen::Vector3d nb = edge.cross(b[2] - a[0]);
  return na.dot(nb) > 0 && na.cross(nb).norm() <= 1e-12 * na.norm() * nb.norm();
}

bool PairMeets(const Surface& surface, int first, int second) {
  std::array<int, 3> a{};
  std::array<int, 3> b{};
  for (int c = 0; c < 3; ++c) {
    a[c] = surface.triangles(c, first);
    b[c] = surface.triangles(c, second);
  }
  int shared = 0;
  for (int i = 0; i < 3; ++i) {
    const auto same = std::find(b.begin() + shared, b.end(), a[i]);
    if (same == b.end()) continue;
    std::swap(a[shared], a[i]);
    std::iter_swap(b.begin() + shared, same);
    ++shared;
  }
  if (shared == 3) return false;  // Doubled: reported as such.
  Triangle x;
  Triangle y;
  for (int c = 0; c < 3; ++c) {
    x[c] = surface.nodes_mm.col(a[c]);
    y[c] = surface.nodes_mm.col(b[c]);
  }
  return MeetBeyond(x, y, shared);
}

}  // namespace

bool TrianglesIntersect(const Triangle& a, const Triangle& b) {
  for (int i = 0; i < 3; ++i) {
    if (SegmentMeets(a[i], a[(i + 1) % 3], b) || SegmentMeets(b[i], b[(i + 1) % 3], a)) return true;
  }
  return false;
}

std::vector<std::pair<int, int>> IntersectingPairs(const Surface& surface, std::size_t limit) {
  // Sweep along x over boxes sorted by their left side; y and z first weed out most pairs.
  struct Box {
    Eigen::Vector3d low, high;
    int triangle;
  };
  const auto count = static_cast<int>(surface.triangles.cols());
  std::vector<Box> boxes(count);
  for (int t = 0; t < count; ++t) {
    const Eigen::Vector3d a = surface.nodes_mm.col(surface.triangles(0, t));
    const Eigen::Vector3d b = surface.nodes_mm.col(surface.triangles(1, t));
    const Eigen::Vector3d c = surface.nodes_mm.col(surface.triangles(2, t));
    boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), t};
  }
  std::ranges::sort(boxes, [](const Box& a, const Box& b) {
    return a.low[0] != b.low[0] ? a.low[0] < b.low[0] : a.triangle < b.triangle;
  });
  std::vector<std::pair<int, int>> out;
  for (std::size_t i = 0; i < boxes.size() && out.size() < limit; ++i) {
    for (std::size_t j = i + 1; j < boxes.size() && boxes[j].low[0] <= boxes[i].high[0]; ++j) {
      if (boxes[j].low[1] > boxes[i].high[1] || boxes[i].low[1] > boxes[j].high[1] ||
          boxes[j].low[2] > boxes[i].high[2] || boxes[i].low[2] > boxes[j].high[2]) {
        continue;
      }
      if (PairMeets(surface, boxes[i].triangle, boxes[j].triangle)) {
        out.push_back(std::minmax(boxes[i].triangle, boxes[j].triangle));
      }
    }
  }
  std::ranges::sort(out);
  if (out.size() > limit) out.resize(limit);
  return out;
}

}  // namespace acus::mesh
