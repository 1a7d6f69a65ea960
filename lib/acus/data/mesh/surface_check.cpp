#include "acus/data/mesh/surface_check.h"

#include <algorithm>
#include <array>

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_edges.h"
#include "acus/data/mesh/triangle_intersection.h"

namespace acus::mesh {
namespace {

constexpr std::size_t kMostPairs = 10000;

void Note(Defect& defect, const Eigen::Vector3d& place_mm) {
  if (defect.count++ == 0) defect.first_mm = place_mm;
}

Eigen::Vector3d CentreOf(const Surface& s, int t) {
  return (s.nodes_mm.col(s.triangles(0, t)) + s.nodes_mm.col(s.triangles(1, t)) +
          s.nodes_mm.col(s.triangles(2, t))) /
         3.0;
}

void CheckNodes(const Surface& surface, SurfaceReport& out) {
  std::vector<int> order(surface.nodes_mm.cols());
  for (std::size_t n = 0; n < order.size(); ++n) order[n] = static_cast<int>(n);
  const auto place = [&](int n) {
    return std::array<double, 3>{surface.nodes_mm(0, n), surface.nodes_mm(1, n),
                                 surface.nodes_mm(2, n)};
  };
  std::ranges::sort(order,
                    [&](int a, int b) { return std::pair(place(a), a) < std::pair(place(b), b); });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (place(order[i - 1]) == place(order[i])) {
      Note(out.duplicate_nodes, surface.nodes_mm.col(order[i]));
    }
  }
  std::vector<bool> is_used(order.size(), false);
  for (Eigen::Index i = 0; i < surface.triangles.size(); ++i)
    is_used[surface.triangles.data()[i]] = true;
  for (std::size_t n = 0; n < is_used.size(); ++n) {
    if (is_used[n])
      ++out.euler_number;
    else
      Note(out.loose_nodes, surface.nodes_mm.col(static_cast<Eigen::Index>(n)));
  }
}

void CheckTriangles(const Surface& surface, SurfaceReport& out) {
  std::vector<std::array<int, 4>> sorted;
  for (int t = 0; t < surface.triangles.cols(); ++t) {
    std::array<int, 3> n{surface.triangles(0, t), surface.triangles(1, t), surface.triangles(2, t)};
    std::ranges::sort(n);
    sorted.push_back({n[0], n[1], n[2], t});
    const Eigen::Vector3d ab = surface.nodes_mm.col(surface.triangles(1, t)) -
                               surface.nodes_mm.col(surface.triangles(0, t));
    const Eigen::Vector3d ac = surface.nodes_mm.col(surface.triangles(2, t)) -
                               surface.nodes_mm.col(surface.triangles(0, t));
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    // Thinner than a millionth of its length.
    if (!(ab.cross(ac).norm() > 1e-6 * longest)) Note(out.flat_triangles, CentreOf(surface, t));
  }
  std::ranges::sort(sorted);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin())) {
      Note(out.duplicate_triangles, CentreOf(surface, sorted[i][3]));
    }
  }
}

void CheckEdges(const Surface& surface, SurfaceReport& out) {
  Groups components(surface.triangles.cols());
  // Corners of triangles, joined over shared edges: a node with two groups joins two sheets.
  Groups corners(3 * surface.triangles.cols());
  const auto corner = [&](int t, int n) {
    for (int c = 0; c < 3; ++c) {
      if (surface.triangles(c, t) == n) return 3 * t + c;
    }
    return 3 * t;
  };
  ForEachEdge(SortedHalfEdges(surface.triangles), [&](const HalfEdge* h, std::size_t count) {
    ++out.num_edges;
    const Eigen::Vector3d middle =
        0.5 * (surface.nodes_mm.col(h[0].low) + surface.nodes_mm.col(h[0].high));
    if (count == 1) Note(out.open_edges, middle);
    if (count > 2) Note(out.crowded_edges, middle);
    if (count == 2 && h[0].is_forward == h[1].is_forward) Note(out.flipped_edges, middle);
    for (std::size_t i = 1; i < count; ++i) {
      components.Join(h[0].triangle, h[i].triangle);
      for (const int n : {h[0].low, h[0].high}) {
        corners.Join(corner(h[0].triangle, n), corner(h[i].triangle, n));
      }
    }
  });
  for (int t = 0; t < surface.triangles.cols(); ++t) out.num_components += components.Find(t) == t;
  std::vector<int> group(surface.nodes_mm.cols(), -1);
  std::vector<bool> is_noted(surface.nodes_mm.cols(), false);
  for (int i = 0; i < 3 * surface.triangles.cols(); ++i) {
    const int n = surface.triangles(i % 3, i / 3);
    const int g = corners.Find(i);
    if (group[n] < 0) group[n] = g;
    if (group[n] == g || is_noted[n]) continue;
    is_noted[n] = true;
    Note(out.crowded_nodes, surface.nodes_mm.col(n));
  }
}

}  // namespace

SurfaceReport CheckSurface(const Surface& surface) {
  SurfaceReport out;
  out.num_nodes = surface.nodes_mm.cols();
  out.num_triangles = surface.triangles.cols();
  CheckNodes(surface, out);
  CheckTriangles(surface, out);
  CheckEdges(surface, out);
  for (const auto& [a, b] : IntersectingPairs(surface, kMostPairs)) {
    Note(out.intersections, 0.5 * (CentreOf(surface, a) + CentreOf(surface, b)));
  }
  out.euler_number += out.num_triangles - out.num_edges;
  out.volume_mm3 = SignedVolumeMm3(surface);
  return out;
}

std::vector<std::string> SurfaceReport::Sentences() const {
  std::vector<std::string> out;
  const auto say = [&](const Defect& defect, const char* what) {
    if (defect.count == 0) return;
    const Eigen::Vector3d& at = defect.first_mm;
    out.push_back(Message(defect.count, " ", what, ", the first at (", at[0], ", ", at[1], ", ",
                          at[2], ") mm"));
  };
  if (num_triangles == 0) out.push_back("it holds no triangle");
  say(open_edges, "open edge(s): the surface has a hole");
  say(crowded_edges, "edge(s) with more than two triangles");
  say(crowded_nodes, "node(s) where two sheets of the surface touch");
  say(flipped_edges, "edge(s) whose triangles face opposite ways");
  say(intersections, "pair(s) of triangles that cut each other");
  say(flat_triangles, "triangle(s) without area");
  say(duplicate_nodes, "node(s) at the place of another");
  say(duplicate_triangles, "triangle(s) given twice");
  say(loose_nodes, "node(s) of no triangle");
  return out;
}

}  // namespace acus::mesh
