#include "acus/imaging/volume_rendering/slope_volume.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::volume_rendering {
namespace {

constexpr float kReachMm = 1.5F;
constexpr float kLeastReach = 0.7F;
constexpr float kAirHu = -1024.0F;

/// Two rows between which a place lies; null beyond the border.
struct RowPair {
  const std::int16_t* low = nullptr;
  const std::int16_t* high = nullptr;
  float share = 0.0F;

  float At(int i) const {
    if (low == nullptr) return kAirHu;
    const auto first = static_cast<float>(low[i]);
    return first + share * (static_cast<float>(high[i]) - first);
  }
};

/// Elements `stride` apart from `first` on.
RowPair PairAt(const std::int16_t* first, std::ptrdiff_t stride, float at, int size) {
  if (at < 0.0F || at > static_cast<float>(size - 1)) return {};
  const int low = std::min(static_cast<int>(at), size - 2);
  return {first + stride * low, first + stride * (low + 1), at - static_cast<float>(low)};
}

std::int8_t UnitsOf(float slope) {
  return static_cast<std::int8_t>(std::lrint(slope / SlopeVolume::kUnit));
}

}  // namespace

SlopeVolume::SlopeVolume(const volume::CtVolume& ct, int num_threads) : size_(ct.geometry.size) {
  const Eigen::Array3f spacing_mm = ct.geometry.spacing_mm.cast<float>();
  reach_ = (kReachMm / spacing_mm).max(kLeastReach);
  per_hu_ = 1.0F / (2.0F * reach_ * spacing_mm);
  units_.resize(4 * ct.geometry.num_voxels());
  ParallelFor(size_[2], num_threads, [&](int k) {
    for (int j = 0; j < size_[1]; ++j) FillRow(ct, j, k);
  });
}

void SlopeVolume::FillRow(const volume::CtVolume& ct, int j, int k) {
  const volume::Geometry& grid = ct.geometry;
  const std::ptrdiff_t row = size_[0];
  const std::int16_t* here = &ct.voxels[grid.Index(0, j, k)];
  const std::int16_t* of_slice = &ct.voxels[grid.Index(0, 0, k)];
  const std::int16_t* of_row = &ct.voxels[grid.Index(0, j, 0)];
  const auto in = [](int at) { return static_cast<float>(at); };
  const RowPair below = PairAt(of_slice, row, in(j)-reach_[1], size_[1]);
  const RowPair above = PairAt(of_slice, row, in(j) + reach_[1], size_[1]);
  const RowPair before = PairAt(of_row, row * size_[1], in(k)-reach_[2], size_[2]);
  const RowPair after = PairAt(of_row, row * size_[1], in(k) + reach_[2], size_[2]);
  std::int8_t* out = &units_[4 * grid.Index(0, j, k)];
  for (int i = 0; i < size_[0]; ++i, out += 4) {
    const RowPair left = PairAt(here, 1, in(i)-reach_[0], size_[0]);
    const RowPair right = PairAt(here, 1, in(i) + reach_[0], size_[0]);
    Eigen::Array3f slope = {right.At(0) - left.At(0), above.At(i) - below.At(i),
                            after.At(i) - before.At(i)};
    slope *= per_hu_;
    const float square = slope.square().sum();
    if (square > kSteepest * kSteepest) slope *= kSteepest / std::sqrt(square);
    for (int axis = 0; axis < 3; ++axis) out[axis] = UnitsOf(slope[axis]);
  }
}

Eigen::Vector3f SlopeVolume::At(const Eigen::Vector3f& index) const noexcept {
  const Eigen::Array3i cell = index.array().cast<int>().max(0).min(size_ - 2);
  const Eigen::Array3f share = index.array() - cell.cast<float>();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int n = 0; n < 8; ++n) {
    const Eigen::Array3i at(n & 1, (n >> 1) & 1, n >> 2);
    const Eigen::Array3i voxel = cell + at;
    const auto number = (static_cast<std::size_t>(voxel[2]) * static_cast<std::size_t>(size_[1]) +
                         static_cast<std::size_t>(voxel[1])) *
                            static_cast<std::size_t>(size_[0]) +
                        static_cast<std::size_t>(voxel[0]);
    const std::int8_t* units = &units_[4 * number];
    const float weight = (at == 1).select(share, 1.0F - share).prod();
    sum += weight * Eigen::Vector3f(units[0], units[1], units[2]);
  }
  return kUnit * sum;
}

}  // namespace acus::volume_rendering
