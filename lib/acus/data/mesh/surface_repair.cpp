#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_check.h"
#include "acus/data/mesh/surface_edges.h"
#include "acus/data/mesh/triangle_intersection.h"

namespace acus::mesh {
namespace {

/// The triangles `kept` and the nodes that they use.
Surface Subset(const Surface& surface, const std::vector<Eigen::Vector3i>& kept) {
  std::vector<int> number(surface.nodes_mm.cols(), -1);
  for (const auto& t : kept) {
    for (int c = 0; c < 3; ++c) number[t[c]] = 0;
  }
  int count = 0;
  for (int& n : number) {
    if (n == 0) n = count++;
  }
  Surface out;
  out.nodes_mm.resize(3, count);
  for (std::size_t n = 0; n < number.size(); ++n) {
    if (number[n] >= 0) out.nodes_mm.col(number[n]) = surface.nodes_mm.col(n);
  }
  out.triangles.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t t = 0; t < kept.size(); ++t) {
    for (int c = 0; c < 3; ++c) out.triangles(c, t) = number[kept[t][c]];
  }
  return out;
}

/// Each node's stand-in: the first node within `distance_mm`.
std::vector<int> Welded(const Eigen::Matrix3Xd& nodes, double distance_mm) {
  std::vector<int> out(nodes.cols());
  using Cell = std::array<long long, 3>;
  std::map<Cell, std::vector<int>> cells;
  const double size = std::max(distance_mm, 1e-12);
  for (int n = 0; n < nodes.cols(); ++n) {
    out[n] = n;
    Cell here;
    for (int d = 0; d < 3; ++d) here[d] = std::llround(std::floor(nodes(d, n) / size));
    double nearest = distance_mm;
    for (int k = 0; k < 27; ++k) {
      const auto cell =
          cells.find({here[0] + k % 3 - 1, here[1] + k / 3 % 3 - 1, here[2] + k / 9 - 1});
      if (cell == cells.end()) continue;
      for (const int other : cell->second) {
        const double distance = (nodes.col(other) - nodes.col(n)).norm();
        if (distance <= nearest) {
          nearest = distance;
          out[n] = other;
        }
      }
    }
    if (out[n] == n) cells[here].push_back(n);
  }
  return out;
}

class Repairer {
 public:
  Repairer(const Surface& surface, const RepairLimits& limits) : limits_(limits) {
    out_.surface = surface;
  }

  Repair Run() {
    Weld();
    DropUseless();
    Orient();
    CloseHoles();
    Unfold();
    FaceOutwards();
    return std::move(out_);
  }

 private:
  Surface& s() { return out_.surface; }
  void Say(long long count, const char* what) {
    if (count > 0) out_.done.push_back(Message(count, " ", what));
  }

  void Weld() {
    if (s().nodes_mm.cols() == 0) return;
    const double diagonal_mm =
        (s().nodes_mm.rowwise().maxCoeff() - s().nodes_mm.rowwise().minCoeff()).norm();
    // Not below what the coordinates themselves resolve: the cells are counted in whole numbers.
    const double resolution_mm = 1e-15 * s().nodes_mm.cwiseAbs().maxCoeff();
    const std::vector<int> number =
        Welded(s().nodes_mm, std::max(limits_.weld_share * diagonal_mm, resolution_mm));
    long long welded = 0;
    for (std::size_t n = 0; n < number.size(); ++n) welded += number[n] != static_cast<int>(n);
    for (int& n : s().triangles.reshaped()) n = number[n];
    Say(welded, "node(s) joined with another at the same place");
  }

  void DropUseless() {
    std::set<std::array<int, 3>> seen;
    std::vector<Eigen::Vector3i> kept;
    for (int t = 0; t < s().triangles.cols(); ++t) {
      std::array<int, 3> n{s().triangles(0, t), s().triangles(1, t), s().triangles(2, t)};
      std::ranges::sort(n);
      if (n[0] == n[1] || n[1] == n[2] || !seen.insert(n).second) continue;
      kept.emplace_back(s().triangles.col(t));
    }
    Say(s().triangles.cols() - static_cast<long long>(kept.size()),
        "flat or doubled triangle(s) dropped");
    out_.surface = Subset(s(), kept);
  }

  /// Turns triangles so that neighbours over edges of exactly two triangles agree.
  void Orient() {
    const Eigen::Index count = s().triangles.cols();
    std::vector<std::vector<std::pair<int, bool>>> neighbours(count);  // And whether they disagree.
    ForEachEdge(SortedHalfEdges(s().triangles), [&](const HalfEdge* h, std::size_t n) {
      if (n != 2) return;
      const bool disagree = h[0].is_forward == h[1].is_forward;
      neighbours[h[0].triangle].emplace_back(h[1].triangle, disagree);
      neighbours[h[1].triangle].emplace_back(h[0].triangle, disagree);
    });
    std::vector<int> turn(count, -1);
    long long turned = 0;
    for (int seed = 0; seed < count; ++seed) {
      if (turn[seed] >= 0) continue;
      turn[seed] = 0;
      std::vector<int> piece{seed};
      long long flips = 0;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const int t = piece[i];
        flips += turn[t];
        for (const auto& [other, disagree] : neighbours[t]) {
          if (turn[other] >= 0) continue;
          turn[other] = disagree ? 1 - turn[t] : turn[t];
          piece.push_back(other);
        }
      }
      // The way of the majority stays.
      const bool is_mostly_turned = 2 * flips > static_cast<long long>(piece.size());
      turned += is_mostly_turned ? static_cast<long long>(piece.size()) - flips : flips;
      for (const int t : piece) {
        if (turn[t] != static_cast<int>(is_mostly_turned)) {
          std::swap(s().triangles(1, t), s().triangles(2, t));
        }
      }
    }
    Say(turned, "triangle(s) turned to the orientation of the adjacent ones");
  }

  /// Fills each simple loop of open edges with a fan around its centre.
  void CloseHoles() {
    std::map<int, int> next;  // Along the hole: against the way of the triangle at its edge.
    std::set<int> branching;
    ForEachEdge(SortedHalfEdges(s().triangles), [&](const HalfEdge* h, std::size_t n) {
      if (n != 1) return;
      const int from = h->is_forward ? h->high : h->low;
      const int to = h->is_forward ? h->low : h->high;
      if (!next.emplace(from, to).second) branching.insert(from);
    });
    std::vector<Eigen::Vector3d> nodes;
    std::vector<Eigen::Vector3i> triangles;
    const auto first_new = static_cast<int>(s().nodes_mm.cols());
    while (!next.empty()) {
      std::vector<int> loop;
      const int start = next.begin()->first;
      bool is_simple = true;
      for (int n = start;;) {
        const auto step = next.find(n);
        if (step == next.end()) {
          is_simple = false;
          break;
        }
        loop.push_back(n);
        is_simple = is_simple && !branching.contains(n);
        n = step->second;
        next.erase(step);
        if (n == start) break;
      }
      if (!is_simple || loop.size() < 3 || static_cast<int>(loop.size()) > limits_.longest_hole)
        continue;
      if (loop.size() == 3) {
        triangles.emplace_back(loop[0], loop[1], loop[2]);
      } else {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (const int n : loop) centre += s().nodes_mm.col(n);
        const int hub = first_new + static_cast<int>(nodes.size());
        nodes.push_back(centre / static_cast<double>(loop.size()));
        for (std::size_t i = 0; i < loop.size(); ++i) {
          triangles.emplace_back(loop[i], loop[(i + 1) % loop.size()], hub);
        }
      }
      ++holes_;
    }
    Append(nodes, triangles);
    Say(holes_, "hole(s) closed");
  }

  void Append(const std::vector<Eigen::Vector3d>& nodes,
              const std::vector<Eigen::Vector3i>& triangles) {
    const Eigen::Index old_nodes = s().nodes_mm.cols();
    const Eigen::Index old_triangles = s().triangles.cols();
    s().nodes_mm.conservativeResize(3, old_nodes + static_cast<Eigen::Index>(nodes.size()));
    s().triangles.conservativeResize(3,
                                     old_triangles + static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) s().nodes_mm.col(old_nodes + n) = nodes[n];
    for (std::size_t t = 0; t < triangles.size(); ++t)
      s().triangles.col(old_triangles + t) = triangles[t];
  }

  /// Draws the nodes of triangles that cut each other to the middle of their neighbours.
  void Unfold() {
    const Eigen::Matrix3Xd before = s().nodes_mm;
    const auto most =
        static_cast<std::size_t>(limits_.folded_share * static_cast<double>(s().triangles.cols()));
    std::vector<std::vector<int>> around(before.cols());
    for (int t = 0; t < s().triangles.cols(); ++t) {
      for (int c = 0; c < 3; ++c) {
        for (int d = 1; d < 3; ++d)
          around[s().triangles(c, t)].push_back(s().triangles((c + d) % 3, t));
      }
    }
    std::set<int> moved;
    for (int round = 0; round < 20; ++round) {
      const auto pairs = IntersectingPairs(s(), most + 1);
      if (pairs.empty()) {
        Say(static_cast<long long>(moved.size()),
            "node(s) smoothed where triangles cut each other");
        return;
      }
      if (pairs.size() > most) break;
      for (const auto& [a, b] : pairs) {
        for (const int t : {a, b}) {
          for (int c = 0; c < 3; ++c) moved.insert(s().triangles(c, t));
        }
      }
      const Eigen::Matrix3Xd now = s().nodes_mm;
      for (const int n : moved) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const int other : around[n]) sum += now.col(other);
        s().nodes_mm.col(n) = 0.5 * now.col(n) + 0.5 * sum / static_cast<double>(around[n].size());
      }
    }
    s().nodes_mm = before;  // Not a small fold.
  }

  void FaceOutwards() {
    if (SignedVolumeMm3(s()) >= 0.0) return;
    s().triangles.row(1).swap(s().triangles.row(2));
    Say(s().triangles.cols(), "triangle(s) turned to face outwards");
  }

  RepairLimits limits_;
  Repair out_;
  long long holes_ = 0;
};

}  // namespace

Repair RepairSurface(const Surface& surface, const RepairLimits& limits) {
  return Repairer(surface, limits).Run();
}

}  // namespace acus::mesh
