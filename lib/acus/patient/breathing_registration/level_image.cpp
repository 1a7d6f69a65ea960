#include "acus/patient/breathing_registration/level_image.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::breathing_registration {
namespace {

/// What of a line of voxels makes one voxel of a coarser line.
struct LineWeights {
  int first = 0;
  std::vector<float> weight;
};

std::vector<LineWeights> WeightsAlong(int from_size, double from_mm, int to_size, double to_mm) {
  const double sigma_mm = 0.5 * to_mm;
  std::vector<LineWeights> out(static_cast<std::size_t>(to_size));
  for (int n = 0; n < to_size; ++n) {
    const double at_mm = n * to_mm;
    const double reach_mm = 1.25 * to_mm;
    const int first =
        std::clamp(static_cast<int>(std::ceil((at_mm - reach_mm) / from_mm)), 0, from_size - 1);
    const int last = std::clamp(static_cast<int>(std::floor((at_mm + reach_mm) / from_mm)), first,
                                from_size - 1);
    LineWeights& line = out[static_cast<std::size_t>(n)];
    line.first = first;
    double sum = 0.0;
    std::vector<double> weight;
    for (int m = first; m <= last; ++m) {
      const double z = (m * from_mm - at_mm) / sigma_mm;
      weight.push_back(std::exp(-0.5 * z * z));
      sum += weight.back();
    }
    for (const double w : weight) line.weight.push_back(static_cast<float>(w / sum));
  }
  return out;
}

/// `lookup(n)` is value n of an image of `size`; averages along `axis`.
template <class Lookup>
std::vector<float> AlongAxis(const Lookup& lookup, const Eigen::Array3i& size, int axis,
                             const std::vector<LineWeights>& lines, int num_threads) {
  Eigen::Array3i to = size;
  to[axis] = static_cast<int>(lines.size());
  const std::array<std::size_t, 3> step = {
      1, static_cast<std::size_t>(size[0]),
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])};
  std::vector<float> out(static_cast<std::size_t>(to[0]) * static_cast<std::size_t>(to[1]) *
                         static_cast<std::size_t>(to[2]));
  ParallelFor(to[2], num_threads, [&](int k) {
    std::size_t n = static_cast<std::size_t>(k) * static_cast<std::size_t>(to[0]) *
                    static_cast<std::size_t>(to[1]);
    for (int j = 0; j < to[1]; ++j) {
      for (int i = 0; i < to[0]; ++i, ++n) {
        std::array<int, 3> at = {i, j, k};
        const LineWeights& line =
            lines[static_cast<std::size_t>(at[static_cast<std::size_t>(axis)])];
        at[static_cast<std::size_t>(axis)] = line.first;
        std::size_t from = static_cast<std::size_t>(at[0]) * step[0] +
                           static_cast<std::size_t>(at[1]) * step[1] +
                           static_cast<std::size_t>(at[2]) * step[2];
        float sum = 0.0F;
        for (const float weight : line.weight) {
          sum += weight * lookup(from);
          from += step[static_cast<std::size_t>(axis)];
        }
        out[n] = sum;
      }
    }
  });
  return out;
}

template <class Lookup>
volume::Grid<float> AveragedBy(const Lookup& lookup, const volume::Geometry& from,
                               const volume::Geometry& to, int num_threads) {
  const auto lines = [&](int axis) {
    return WeightsAlong(from.size[axis], from.spacing_mm[axis], to.size[axis], to.spacing_mm[axis]);
  };
  Eigen::Array3i size = from.size;
  std::vector<float> values = AlongAxis(lookup, size, 0, lines(0), num_threads);
  size[0] = to.size[0];
  for (int axis = 1; axis < 3; ++axis) {
    const std::vector<float> before = std::move(values);
    values =
        AlongAxis([&](std::size_t n) { return before[n]; }, size, axis, lines(axis), num_threads);
    size[axis] = to.size[axis];
  }
  volume::Grid<float> out;
  out.geometry = to;
  out.voxels = std::move(values);
  return out;
}

}  // namespace

volume::Geometry CubicGrid(const volume::Geometry& ct, double spacing_mm) {
  volume::Geometry grid = ct;
  const Eigen::Array3d extent_mm = ct.spacing_mm * (ct.size - 1).cast<double>();
  grid.spacing_mm = Eigen::Array3d::Constant(spacing_mm);
  grid.size = (extent_mm / spacing_mm + 1e-6).floor().cast<int>() + 1;
  return grid;
}

double Contrast(double hu) noexcept {
  if (hu < -200.0) return -200.0 + 0.25 * (std::max(hu, -1024.0) + 200.0);
  if (hu > 300.0) return 300.0 + 0.2 * (std::min(hu, 1500.0) - 300.0);
  return hu;
}

volume::Grid<float> Averaged(const volume::CtVolume& ct, const volume::Geometry& grid,
                             int num_threads) {
  std::vector<float> contrast(65536);
  for (int hu = -32768; hu < 32768; ++hu) {
    contrast[static_cast<std::size_t>(hu + 32768)] = static_cast<float>(Contrast(hu));
  }
  return AveragedBy(
      [&](std::size_t n) { return contrast[static_cast<std::size_t>(ct.voxels[n] + 32768)]; },
      ct.geometry, grid, num_threads);
}

volume::Grid<float> Averaged(const volume::Grid<float>& image, const volume::Geometry& grid,
                             int num_threads) {
  return AveragedBy([&](std::size_t n) { return image.voxels[n]; }, image.geometry, grid,
                    num_threads);
}

ModelImage::ModelImage(const volume::Grid<float>& image, int num_threads)
    : geometry_(image.geometry), voxels_(image.voxels.size()) {
  const Eigen::Array3i& size = geometry_.size;
  ParallelFor(size[2], num_threads, [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const auto slope = [&](int di, int dj, int dk) {
          const int hi = std::min(i + di, size[0] - 1), lo = std::max(i - di, 0);
          const int hj = std::min(j + dj, size[1] - 1), lj = std::max(j - dj, 0);
          const int hk = std::min(k + dk, size[2] - 1), lk = std::max(k - dk, 0);
          const int step = hi - lo + hj - lj + hk - lk;
          return step == 0
                     ? 0.0F
                     : (image.At(hi, hj, hk) - image.At(lo, lj, lk)) / static_cast<float>(step);
        };
        voxels_[geometry_.Index(i, j, k)] = {image.At(i, j, k), slope(1, 0, 0), slope(0, 1, 0),
                                             slope(0, 0, 1)};
      }
    }
  });
}

ModelImage::Sample ModelImage::At(const Eigen::Vector3f& index) const noexcept {
  const Eigen::Array3i& size = geometry_.size;
  if (!((index.array() >= 0.0F).all() && (index.array() <= (size - 1).cast<float>()).all())) {
    return {};
  }
  const Eigen::Array3i base = index.array().cast<int>().min(size - 2).max(0);
  const Eigen::Array3f t = index.array() - base.cast<float>();
  const std::size_t row = static_cast<std::size_t>(size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(size[1]);
  const Eigen::Array4f* v = &voxels_[geometry_.Index(base[0], base[1], base[2])];
  const auto line = [&](std::size_t offset) -> Eigen::Array4f {
    return (1.0F - t[0]) * v[offset] + t[0] * v[offset + 1];
  };
  const Eigen::Array4f low = (1.0F - t[1]) * line(0) + t[1] * line(row);
  const Eigen::Array4f high = (1.0F - t[1]) * line(slice) + t[1] * line(slice + row);
  const Eigen::Array4f value = (1.0F - t[2]) * low + t[2] * high;
  return {.value = value[0], .gradient = value.tail<3>().matrix(), .within = true};
}

}  // namespace acus::breathing_registration
