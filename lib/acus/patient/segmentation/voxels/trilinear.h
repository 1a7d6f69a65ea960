// Values between the voxels of a volume.
#pragma once

#include <algorithm>
#include <array>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// Trilinear; beyond the grid as at its border. @param index  In voxels.
template <typename Scalar>
double TrilinearAt(const volume::Grid<Scalar>& grid, const Eigen::Vector3d& index) {
  const auto& size = grid.geometry.size;
  std::array<int, 3> low{};
  std::array<double, 3> part{};
  for (int d = 0; d < 3; ++d) {
    const double x = std::clamp(index[d], 0.0, size[d] - 1.0);
    low[static_cast<std::size_t>(d)] = std::min(static_cast<int>(x), std::max(size[d] - 2, 0));
    part[static_cast<std::size_t>(d)] = x - low[static_cast<std::size_t>(d)];
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::array<int, 3> at{};
    for (std::size_t d = 0; d < 3; ++d) {
      const bool upper = ((corner >> d) & 1) != 0;
      weight *= upper ? part[d] : 1.0 - part[d];
      at[d] = std::min(low[d] + (upper ? 1 : 0), size[static_cast<Eigen::Index>(d)] - 1);
    }
    if (weight > 0.0) sum += weight * static_cast<double>(grid.At(at[0], at[1], at[2]));
  }
  return sum;
}

}  // namespace acus::segmentation
