#include "acus/data/mesh/triangle_distance.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "acus/data/mesh/nearest_triangle.h"

namespace acus::mesh {

double SquaredDistanceToTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d weights = NearestWeights(x, a, b, c);
  return (x - a - weights[1] * (b - a) - weights[2] * (c - a)).squaredNorm();
}

TriangleDistance::TriangleDistance(Eigen::Matrix3Xd corners) : corners_(std::move(corners)) {
  const Eigen::Index count = corners_.cols() / 3;
  first_.assign(2, 0);
  if (count == 0) return;
  low_ = corners_.rowwise().minCoeff();
  const Eigen::Array3d extent = corners_.rowwise().maxCoeff().array() - low_;
  double edges = 0.0;
  for (Eigen::Index t = 0; t < count; ++t) {
    edges += (corners_.col(3 * t + 1) - corners_.col(3 * t)).norm();
  }
  // Cells about as large as a triangle, but not many more of them than triangles.
  cell_ = std::max({edges / static_cast<double>(count), extent.maxCoeff() / 256.0, 1e-9});
  size_ = (extent / cell_).floor().cast<int>() + 1;
  const auto for_cells = [&](Eigen::Index t, const auto& visit) {
    const auto x = corners_.middleCols<3>(3 * t);
    const Eigen::Array3i from =
        ((x.rowwise().minCoeff().array() - low_) / cell_).floor().cast<int>().max(0);
    const Eigen::Array3i to =
        ((x.rowwise().maxCoeff().array() - low_) / cell_).floor().cast<int>().min(size_ - 1);
    for (int k = from[2]; k <= to[2]; ++k) {
      for (int j = from[1]; j <= to[1]; ++j) {
        for (int i = from[0]; i <= to[0]; ++i) visit(Index(i, j, k));
      }
    }
  };
  first_.assign(Index(0, 0, size_[2]) + 1, 0);
  for (Eigen::Index t = 0; t < count; ++t) {
    for_cells(t, [&](std::size_t cell) { ++first_[cell + 1]; });
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  members_.resize(first_.back());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (Eigen::Index t = 0; t < count; ++t) {
    for_cells(t, [&](std::size_t cell) { members_[next[cell]++] = static_cast<int>(t); });
  }
}

double TriangleDistance::At(const Eigen::Vector3d& x, double limit) const {
  if (members_.empty()) return limit;
  const Eigen::Array3d place = (x.array() - low_) / cell_;
  const Eigen::Array3d last = (size_ - 1).cast<double>();
  const Eigen::Array3i centre = place.floor().max(0.0).min(last).cast<int>();
  // From x to the nearest wall of its cell, in cells; 0 outside the grid.
  const double wall = std::max(0.0, 0.5 - (place - (centre.cast<double>() + 0.5)).abs().maxCoeff());
  double best = limit * limit;
  const auto search = [&](int i, int j, int k) {
    const std::size_t cell = Index(i, j, k);
    for (int m = first_[cell]; m < first_[cell + 1]; ++m) {
      const Eigen::Index t = 3 * static_cast<Eigen::Index>(members_[m]);
      best = std::min(best, SquaredDistanceToTriangle(x, corners_.col(t), corners_.col(t + 1),
                                                      corners_.col(t + 2)));
    }
  };
  for (int r = 0; r <= size_.maxCoeff(); ++r) {
    const double away = cell_ * (r - 1.0 + wall);  // Of the ring of cells of radius r.
    if (r > 0 && away * away >= best) break;
    const Eigen::Array3i from = (centre - r).max(0);
    const Eigen::Array3i to = (centre + r).min(size_ - 1);
    for (int k = from[2]; k <= to[2]; ++k) {
      for (int j = from[1]; j <= to[1]; ++j) {
        const bool is_rim = std::abs(k - centre[2]) == r || std::abs(j - centre[1]) == r;
        for (int i = from[0]; i <= to[0]; ++i) {
          if (is_rim || std::abs(i - centre[0]) == r) search(i, j, k);
        }
      }
    }
  }
  return std::sqrt(best);
}

}  // namespace acus::mesh
