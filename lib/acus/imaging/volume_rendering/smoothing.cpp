#include "acus/imaging/volume_rendering/smoothing.h"

#include <algorithm>
#include <vector>

#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr double kFineMm = 1.5;

std::int16_t Mean(std::int16_t before, std::int16_t here, std::int16_t after) {
  return static_cast<std::int16_t>((before + 2 * here + after + 2) >> 2);
}

/// Along i and j, within one slice.
void SmoothSlice(const volume::Geometry& grid, bool along_i, bool along_j, std::int16_t* slice) {
  const auto width = static_cast<std::size_t>(grid.size[0]);
  const auto rows = static_cast<std::size_t>(grid.size[1]);
  std::vector<std::int16_t> above(width);
  std::vector<std::int16_t> here(width);
  for (std::size_t j = 0; along_i && j < rows; ++j) {
    std::int16_t* row = slice + j * width;
    std::copy_n(row, width, here.begin());
    for (std::size_t i = 0; i < width; ++i) {
      row[i] = Mean(here[i == 0 ? 0 : i - 1], here[i], here[std::min(i + 1, width - 1)]);
    }
  }
  if (!along_j) return;
  std::copy_n(slice, width, above.begin());
  for (std::size_t j = 0; j < rows; ++j) {
    std::int16_t* row = slice + j * width;
    const std::int16_t* below = slice + std::min(j + 1, rows - 1) * width;
    std::copy_n(row, width, here.begin());
    for (std::size_t i = 0; i < width; ++i) row[i] = Mean(above[i], here[i], below[i]);
    above.swap(here);
  }
}

}  // namespace

volume::CtVolume Smoothed(const volume::CtVolume& ct, int num_threads) {
  const volume::Geometry& grid = ct.geometry;
  volume::CtVolume out = ct;
  const auto slice =
      static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
  const auto fine = grid.spacing_mm < kFineMm;
  if (fine[2]) {
    ParallelFor(grid.size[2], num_threads, [&](int k) {
      const auto at = [&](int n) {
        return ct.voxels.data() +
               slice * static_cast<std::size_t>(std::clamp(n, 0, grid.size[2] - 1));
      };
      const std::int16_t* before = at(k - 1);
      const std::int16_t* here = at(k);
      const std::int16_t* after = at(k + 1);
      std::int16_t* to = out.voxels.data() + slice * static_cast<std::size_t>(k);
      for (std::size_t n = 0; n < slice; ++n) to[n] = Mean(before[n], here[n], after[n]);
    });
  }
  ParallelFor(grid.size[2], num_threads, [&](int k) {
    SmoothSlice(grid, fine[0], fine[1], out.voxels.data() + slice * static_cast<std::size_t>(k));
  });
  return out;
}

}  // namespace acus::volume_rendering
