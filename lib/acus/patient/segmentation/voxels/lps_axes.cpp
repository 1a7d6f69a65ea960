#include "acus/patient/segmentation/voxels/lps_axes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::segmentation {

AxisOrder LpsOrder(const volume::Geometry& geometry) {
  AxisOrder order;
  std::array<int, 3> axes = {0, 1, 2};
  double best = -1.0;
  do {
    double sum = 0.0;
    for (int d = 0; d < 3; ++d)
      sum += std::abs(geometry.direction(d, axes[static_cast<std::size_t>(d)]));
    if (sum <= best) continue;
    best = sum;
    order.axis = axes;
  } while (std::ranges::next_permutation(axes).found);
  for (std::size_t d = 0; d < 3; ++d) {
    order.reversed[d] = geometry.direction(static_cast<int>(d), order.axis[d]) < 0.0;
  }
  return order;
}

double ObliquityDeg(const volume::Geometry& geometry) {
  const AxisOrder order = LpsOrder(geometry);
  double least = 1.0;
  for (std::size_t d = 0; d < 3; ++d) {
    least = std::min(least, std::abs(geometry.direction(static_cast<int>(d), order.axis[d])));
  }
  return std::acos(std::min(least, 1.0)) * 180.0 / std::numbers::pi;
}

volume::Geometry Turned(const volume::Geometry& geometry, const AxisOrder& order) {
  volume::Geometry turned;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (std::size_t d = 0; d < 3; ++d) {
    const int axis = order.axis[d];
    const auto to = static_cast<Eigen::Index>(d);
    turned.size[to] = geometry.size[axis];
    turned.spacing_mm[to] = geometry.spacing_mm[axis];
    turned.direction.col(to) = (order.reversed[d] ? -1.0 : 1.0) * geometry.direction.col(axis);
    first[axis] = order.reversed[d] ? geometry.size[axis] - 1 : 0;
  }
  turned.origin_mm = geometry.ct_from_index() * first;
  return turned;
}

}  // namespace acus::segmentation
