#include "acus/patient/segmentation/voxels/rasterise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/base/core/parallel.h"

namespace acus::segmentation {
namespace {

/// Slices of k that one piece of work takes.
constexpr int kSlab = 8;

struct Crossing {
  int row;       ///< Of the slab: k within it times size_j, plus j.
  int turn;      ///< +1 into the surface, -1 out of it.
  double index;  ///< Along i, continuous.
};

/// A node in continuous indices of the grid.
using Node = Eigen::Vector3d;

/// Twice the area that (j, k) spans with the edge from a to b, seen along i; its sign gives the
/// side. The same number for both triangles at an edge, except for the sign. On the edge: as if (j,
/// k) were moved by (-e, -e^2), e above 0 but next to nothing.
struct Side {
  double value;
  bool positive;
};
Side SideOf(const Node& a, const Node& b, double j, double k) {
  const bool forward = a[2] < b[2] || (a[2] == b[2] && a[1] < b[1]);
  const Node& low = forward ? a : b;
  const Node& high = forward ? b : a;
  const double value = (high[1] - low[1]) * (k - low[2]) - (high[2] - low[2]) * (j - low[1]);
  // Moved towards -j the point is on the positive side of an edge that rises; on a level one the
  // move towards -k decides.
  const bool positive = value > 0.0 || (value == 0.0 && high[2] > low[2]);
  return forward ? Side{value, positive} : Side{-value, !positive};
}

/// Where the line along i through (j, k) crosses the triangle, if it does.
bool Cross(const Node& a, const Node& b, const Node& c, int j, int k, Crossing& out) {
  const Side ab = SideOf(a, b, j, k);
  const Side bc = SideOf(b, c, j, k);
  const Side ca = SideOf(c, a, j, k);
  if (ab.positive != bc.positive || bc.positive != ca.positive) return false;
  const double sum = ab.value + bc.value + ca.value;
  out.index = sum != 0.0 ? (bc.value * a[0] + ca.value * b[0] + ab.value * c[0]) / sum
                         : (a[0] + b[0] + c[0]) / 3.0;
  out.turn = ab.positive ? -1 : 1;
  return true;
}

class Slab {
 public:
  Slab(const Eigen::Matrix3Xd& nodes, const mesh::Surface& surface, Winding winding,
       volume::Label label, volume::LabelMap& labels)
      : nodes_(nodes), surface_(surface), winding_(winding), label_(label), labels_(labels) {}

  void Paint(int first_k, const std::vector<int>& triangles) {
    const auto& size = labels_.geometry.size;
    const int end_k = std::min(first_k + kSlab, size[2]);
    std::vector<Crossing> crossings;
    for (const int t : triangles) Collect(t, first_k, end_k, crossings);
    std::ranges::sort(crossings, [](const Crossing& a, const Crossing& b) {
      if (a.row != b.row) return a.row < b.row;
      return a.index != b.index ? a.index < b.index : a.turn < b.turn;
    });
    for (std::size_t begin = 0; begin < crossings.size();) {
      std::size_t end = begin;
      while (end < crossings.size() && crossings[end].row == crossings[begin].row) ++end;
      const int row = crossings[begin].row;
      volume::Label* voxels = &labels_.At(0, row % size[1], first_k + row / size[1]);
      PaintRow(&crossings[begin], end - begin, size[0], voxels);
      begin = end;
    }
  }

 private:
  void Collect(int t, int first_k, int end_k, std::vector<Crossing>& out) const {
    const int size_j = labels_.geometry.size[1];
    const Node a = nodes_.col(surface_.triangles(0, t));
    const Node b = nodes_.col(surface_.triangles(1, t));
    const Node c = nodes_.col(surface_.triangles(2, t));
    const Node low = a.cwiseMin(b).cwiseMin(c);
    const Node high = a.cwiseMax(b).cwiseMax(c);
    const int k0 = std::max(first_k, static_cast<int>(std::ceil(low[2])));
    const int k1 = std::min(end_k - 1, static_cast<int>(std::floor(high[2])));
    const int j0 = std::max(0, static_cast<int>(std::ceil(low[1])));
    const int j1 = std::min(size_j - 1, static_cast<int>(std::floor(high[1])));
    for (int k = k0; k <= k1; ++k) {
      for (int j = j0; j <= j1; ++j) {
        Crossing crossing{};
        if (!Cross(a, b, c, j, k, crossing)) continue;
        crossing.row = (k - first_k) * size_j + j;
        out.push_back(crossing);
      }
    }
  }

  void PaintRow(const Crossing* crossing, std::size_t count, int size_i,
                volume::Label* voxels) const {
    int winding = 0;
    for (std::size_t n = 0; n + 1 < count; ++n) {
      winding += winding_ == Winding::kOriented ? crossing[n].turn : 1;
      const bool inside = winding_ == Winding::kOriented ? winding != 0 : winding % 2 != 0;
      if (!inside) continue;
      // A centre on the surface belongs to what begins there.
      const int from = std::max(0, static_cast<int>(std::ceil(crossing[n].index)));
      const int end = std::min(size_i, static_cast<int>(std::ceil(crossing[n + 1].index)));
      if (end > from) std::fill(voxels + from, voxels + end, label_);
    }
  }

  const Eigen::Matrix3Xd& nodes_;
  const mesh::Surface& surface_;
  Winding winding_;
  volume::Label label_;
  volume::LabelMap& labels_;
};

}  // namespace

void PaintInside(const mesh::Surface& surface, Winding winding, volume::Label label,
                 int num_threads, volume::LabelMap& labels) {
  const volume::Geometry& g = labels.geometry;
  const Eigen::Matrix3Xd nodes = g.index_from_ct() * surface.nodes_mm;
  const int num_slabs = (g.size[2] + kSlab - 1) / kSlab;
  std::vector<std::vector<int>> triangles(static_cast<std::size_t>(num_slabs));
  for (int t = 0; t < surface.triangles.cols(); ++t) {
    double low = nodes(2, surface.triangles(0, t));
    double high = low;
    for (int c = 1; c < 3; ++c) {
      low = std::min(low, nodes(2, surface.triangles(c, t)));
      high = std::max(high, nodes(2, surface.triangles(c, t)));
    }
    // Most triangles are smaller than a voxel: many meet no line at all.
    const int first = std::max(0, static_cast<int>(std::ceil(low)));
    const int last = std::min(g.size[2] - 1, static_cast<int>(std::floor(high)));
    if (first > last) continue;
    for (int s = first / kSlab; s <= last / kSlab; ++s) {
      triangles[static_cast<std::size_t>(s)].push_back(t);
    }
  }
  ParallelFor(num_slabs, num_threads, [&](int s) {
    Slab(nodes, surface, winding, label, labels)
        .Paint(s * kSlab, triangles[static_cast<std::size_t>(s)]);
  });
}

}  // namespace acus::segmentation
