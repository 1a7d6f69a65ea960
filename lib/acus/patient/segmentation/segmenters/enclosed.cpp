#include "acus/patient/segmentation/segmenters/enclosed.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::segmentation {
namespace {

constexpr double kEnclosedGridMm = 2.0;
constexpr float kNowhereMm = 1e9F;

/// Any wall in a block of `factor` voxels makes it a wall.
Mask Blocks(const Mask& walls, const Eigen::Array3i& factor) {
  volume::Geometry g = walls.geometry;
  g.size = (g.size + factor - 1) / factor;
  g.spacing_mm *= factor.cast<double>();
  Mask blocks(g);
  const Eigen::Array3i& size = walls.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        blocks.At(i / factor[0], j / factor[1], k / factor[2]) |= walls.At(i, j, k);
      }
    }
  }
  return blocks;
}

/// Adds 1 to `seen` where a wall lies within `reach_mm` in the direction -`step`.
void Look(const Mask& walls, const Eigen::Array3i& step, double reach_mm,
          volume::Grid<float>& distance_mm, Mask& seen) {
  const volume::Geometry& g = walls.geometry;
  const auto step_mm = static_cast<float>((step.cast<double>() * g.spacing_mm).matrix().norm());
  const auto along = [&](int axis, int n) { return step[axis] < 0 ? g.size[axis] - 1 - n : n; };
  for (int n = 0; n < g.size[2]; ++n) {
    const int k = along(2, n);
    for (int m = 0; m < g.size[1]; ++m) {
      const int j = along(1, m);
      for (int l = 0; l < g.size[0]; ++l) {
        const int i = along(0, l);
        const bool is_first = !g.Contains(i - step[0], j - step[1], k - step[2]);
        const float to_wall =
            is_first ? kNowhereMm : distance_mm.At(i - step[0], j - step[1], k - step[2]) + step_mm;
        if (to_wall <= static_cast<float>(reach_mm)) ++seen.At(i, j, k);
        distance_mm.At(i, j, k) = walls.At(i, j, k) != 0 ? 0.0F : to_wall;
      }
    }
  }
}

}  // namespace

Mask Enclosed(const Mask& walls, double reach_mm, int least, int num_threads) {
  const volume::Geometry& fine = walls.geometry;
  const Eigen::Array3i factor =
      (kEnclosedGridMm / fine.spacing_mm).round().cast<int>().max(1).min(fine.size);
  const Mask blocks = Blocks(walls, factor);
  Mask seen(blocks.geometry);
  volume::Grid<float> distance_mm(blocks.geometry);
  for (int n = 0; n < 27; ++n) {
    const Eigen::Array3i step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    if ((step != 0).any()) Look(blocks, step, reach_mm, distance_mm, seen);
  }
  Mask enclosed(fine);
  ParallelFor(fine.size[2], num_threads, [&](int k) {
    for (int j = 0; j < fine.size[1]; ++j) {
      for (int i = 0; i < fine.size[0]; ++i) {
        const int count = seen.At(i / factor[0], j / factor[1], k / factor[2]);
        enclosed.At(i, j, k) = count >= least ? 1 : 0;
      }
    }
  });
  return enclosed;
}

}  // namespace acus::segmentation
