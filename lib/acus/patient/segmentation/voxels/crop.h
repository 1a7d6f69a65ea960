// Boxes of volumes.
#pragma once

#include <algorithm>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// The voxels of `grid` in `box`, in their place in space. @pre the box is in the grid, not empty.
template <typename Scalar>
volume::Grid<Scalar> Cropped(const volume::Grid<Scalar>& grid, const Box& box) {
  volume::Geometry g = grid.geometry;
  g.size = box.high - box.low + 1;
  g.origin_mm = grid.geometry.ct_from_index() * box.low.template cast<double>().matrix();
  volume::Grid<Scalar> out(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      const std::size_t from = grid.geometry.Index(box.low[0], box.low[1] + j, box.low[2] + k);
      std::copy_n(grid.voxels.begin() + static_cast<std::ptrdiff_t>(from), g.size[0],
                  out.voxels.begin() + static_cast<std::ptrdiff_t>(g.Index(0, j, k)));
    }
  }
  return out;
}

/// The inverse: `part`, cropped by `box`, in its place in `whole`.
template <typename Scalar>
void Paste(const volume::Grid<Scalar>& part, const Box& box, volume::Grid<Scalar>& whole) {
  const Eigen::Array3i& size = part.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const std::size_t to = whole.geometry.Index(box.low[0], box.low[1] + j, box.low[2] + k);
      const auto from = static_cast<std::ptrdiff_t>(part.geometry.Index(0, j, k));
      std::copy_n(part.voxels.begin() + from, size[0],
                  whole.voxels.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
}

}  // namespace acus::segmentation
