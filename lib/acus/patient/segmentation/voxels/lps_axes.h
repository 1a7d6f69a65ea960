// Volumes turned to patient axes: i to the left (+x), j to the back (+y), k to the head (+z).
//
// Only whole axes are exchanged and reversed, so that every voxel keeps its value and its place.
#pragma once

#include <array>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// Which axis of a grid runs along each of x, y, z, and whether it runs backwards.
struct AxisOrder {
  std::array<int, 3> axis = {0, 1, 2};
  std::array<bool, 3> reversed = {false, false, false};
};

/// The order in which the axes of `geometry` come nearest to x, y, z.
AxisOrder LpsOrder(const volume::Geometry& geometry);

/// The largest angle between an axis of `geometry` and the patient axis it comes nearest to, deg.
double ObliquityDeg(const volume::Geometry& geometry);

/// The grid of the same voxels with axes in this order.
volume::Geometry Turned(const volume::Geometry& geometry, const AxisOrder& order);

/// Where voxel (i, j, k) of the turned grid is in the original one.
inline std::size_t OriginalIndex(const volume::Geometry& original, const AxisOrder& order, int i,
                                 int j, int k) {
  const std::array<int, 3> turned = {i, j, k};
  Eigen::Array3i at;
  for (std::size_t d = 0; d < 3; ++d) {
    const int axis = order.axis[d];
    at[axis] = order.reversed[d] ? original.size[axis] - 1 - turned[d] : turned[d];
  }
  return original.Index(at[0], at[1], at[2]);
}

/// `to_lps`: from a grid of geometry `original` to the turned one; otherwise back.
template <typename Scalar>
volume::Grid<Scalar> Turned(const volume::Grid<Scalar>& grid, const volume::Geometry& original,
                            const AxisOrder& order, bool to_lps) {
  const volume::Geometry turned = Turned(original, order);
  volume::Grid<Scalar> out(to_lps ? turned : original);
  for (int k = 0; k < turned.size[2]; ++k) {
    for (int j = 0; j < turned.size[1]; ++j) {
      for (int i = 0; i < turned.size[0]; ++i) {
        const std::size_t there = OriginalIndex(original, order, i, j, k);
        const std::size_t here = turned.Index(i, j, k);
        out.voxels[to_lps ? here : there] = grid.voxels[to_lps ? there : here];
      }
    }
  }
  return out;
}

}  // namespace acus::segmentation
