#include "acus/data/mesh/point_location.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"

namespace acus::mesh {
namespace {

constexpr double kTolerance = 1e-9;

}  // namespace

PointLocation::PointLocation(const TetraMesh& mesh, double tetrahedra_per_cell) {
  ACUS_ASSERT(tetrahedra_per_cell > 0.0);
  const Eigen::Index count = mesh.tetrahedra.cols();
  ACUS_REQUIRE(count > 0, "the mesh holds no tetrahedron");
  low_ = mesh.nodes_mm.rowwise().minCoeff();
  high_ = mesh.nodes_mm.rowwise().maxCoeff();
  const Eigen::Vector3d extent = (high_ - low_).cwiseMax(1e-9);
  const double edge_mm =
      std::cbrt(extent.prod() * tetrahedra_per_cell / static_cast<double>(count));
  for (int d = 0; d < 3; ++d) {
    size_[d] = std::clamp(static_cast<int>(extent[d] / edge_mm), 1, 512);
    cell_mm_[d] = extent[d] / size_[d];
  }
  frames_.reserve(count);
  std::vector<std::pair<Eigen::Vector3i, Eigen::Vector3i>> boxes;
  std::vector<int> sizes(Index(0, 0, size_[2]) + 1, 0);
  const auto for_each_cell = [&](const auto& box, const auto& visit) {
    for (int k = box.first[2]; k <= box.second[2]; ++k) {
      for (int j = box.first[1]; j <= box.second[1]; ++j) {
        for (int i = box.first[0]; i <= box.second[0]; ++i) visit(Index(i, j, k));
      }
    }
  };
  for (Eigen::Index t = 0; t < count; ++t) {
    const Corners x = CornersOf(mesh, t);
    Eigen::Matrix3d edges;
    edges << x[1] - x[0], x[2] - x[0], x[3] - x[0];
    frames_.push_back({x[0], edges.inverse()});
    // A little wider, so that the tolerance of Find() holds over cell borders, too.
    const Eigen::Vector3d margin = 1e-6 * cell_mm_;
    boxes.emplace_back(CellOf(x[0].cwiseMin(x[1]).cwiseMin(x[2]).cwiseMin(x[3]) - margin),
                       CellOf(x[0].cwiseMax(x[1]).cwiseMax(x[2]).cwiseMax(x[3]) + margin));
    for_each_cell(boxes.back(), [&](std::size_t cell) { ++sizes[cell]; });
  }
  first_.assign(sizes.size(), 0);
  for (std::size_t c = 1; c < sizes.size(); ++c) first_[c] = first_[c - 1] + sizes[c - 1];
  members_.resize(first_.back());
  std::vector<int> next = first_;
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for_each_cell(boxes[t],
                  [&](std::size_t cell) { members_[next[cell]++] = static_cast<int>(t); });
  }
}

Eigen::Vector3i PointLocation::CellOf(const Eigen::Vector3d& x_mm) const {
  Eigen::Vector3i out;
  for (int d = 0; d < 3; ++d) {
    const double at = std::floor((x_mm[d] - low_[d]) / cell_mm_[d]);
    out[d] = static_cast<int>(std::clamp(at, 0.0, size_[d] - 1.0));
  }
  return out;
}

std::optional<Location> PointLocation::Find(const Eigen::Vector3d& x_mm) const noexcept {
  const Eigen::Vector3d margin = 1e-6 * cell_mm_;
  if (!((x_mm - low_ + margin).minCoeff() >= 0.0 && (high_ - x_mm + margin).minCoeff() >= 0.0)) {
    return std::nullopt;  // Also where a coordinate is not a number.
  }
  const Eigen::Vector3i cell = CellOf(x_mm);
  const std::size_t index = Index(cell[0], cell[1], cell[2]);
  for (int m = first_[index]; m < first_[index + 1]; ++m) {
    const int t = members_[m];
    Eigen::Vector4d weights;
    weights.tail<3>() = frames_[t].weights_from_place * (x_mm - frames_[t].first);
    weights[0] = 1.0 - weights[1] - weights[2] - weights[3];
    if (!(weights.minCoeff() >= -kTolerance)) continue;
    weights = weights.cwiseMax(0.0);
    return Location{t, weights / weights.sum()};
  }
  return std::nullopt;
}

}  // namespace acus::mesh
