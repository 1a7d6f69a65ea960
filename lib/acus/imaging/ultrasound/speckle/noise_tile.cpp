#include "acus/imaging/ultrasound/speckle/noise_tile.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/ultrasound/speckle/noise_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::ultrasound::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, slicing::kernels::kBlock>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;

HWY_INLINE VF Lerp(VF a, VF b, VF fraction) {
  return hn::Add(a, hn::Mul(fraction, hn::Sub(b, a)));
}

/// Two neighbours along i from one load.
HWY_INLINE VF LerpPair(const std::uint8_t* data, VI offset, VF fraction) {
  const F f;
  const I d;
  const VI byte = hn::Set(d, 255);
  const VI pair = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(data), offset);
  const VF low = hn::ConvertTo(f, hn::And(pair, byte));
  const VF high = hn::ConvertTo(f, hn::And(hn::ShiftRight<8>(pair), byte));
  return Lerp(low, high, fraction);
}

void TileRow(const std::uint8_t* data, int row_bytes, const slicing::kernels::Lines& lines,
             float sample, const float* tile_per_index, int lanes, float* out) {
  const F f;
  const I d;
  const VI mask = hn::Set(d, NoiseTile::kSize - 1);
  const VI row = hn::Set(d, row_bytes);
  const VI one = hn::Set(d, 1);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VI cell[3];
    VF fraction[3];
    for (int a = 0; a < 3; ++a) {
      const VF index = hn::Add(hn::Load(f, lines.start[a] + l),
                               hn::Mul(hn::Set(f, sample), hn::Load(f, lines.step[a] + l)));
      const VF place = hn::Mul(index, hn::Set(f, tile_per_index[a]));
      const VF low = hn::Floor(place);
      fraction[a] = hn::Sub(place, low);
      cell[a] = hn::And(hn::ConvertTo(d, low), mask);
    }
    const VI next_j = hn::And(hn::Add(cell[1], one), mask);
    const VI next_k = hn::And(hn::Add(cell[2], one), mask);
    const auto offset = [&](VI j, VI k) {
      const VI slice_row = hn::Add(hn::ShiftLeft<NoiseTile::kLog2Size>(k), j);
      return hn::Add(hn::Mul(slice_row, row), cell[0]);
    };
    const VF near = Lerp(LerpPair(data, offset(cell[1], cell[2]), fraction[0]),
                         LerpPair(data, offset(next_j, cell[2]), fraction[0]), fraction[1]);
    const VF far = Lerp(LerpPair(data, offset(cell[1], next_k), fraction[0]),
                        LerpPair(data, offset(next_j, next_k), fraction[0]), fraction[1]);
    hn::Store(hn::Mul(Lerp(near, far, fraction[2]), hn::Set(f, 1.0F / 255.0F)), f, out + l);
  }
}

}  // namespace acus::ultrasound::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::ultrasound {

HWY_EXPORT(TileRow);

namespace {

/// Periodic gradient noise (Perlin 2002): gradients towards the twelve edges of a cube, fifth-order
/// fades. Within [-1, 1], 0 at the lattice points.
class GradientNoise {
 public:
  GradientNoise(int cells, std::string_view name, std::uint64_t octave, std::uint64_t seed)
      : cells_(cells), gradient_(static_cast<std::size_t>(cells) * cells * cells) {
    RandomStream random(seed, name, octave);
    for (std::uint8_t& g : gradient_) g = static_cast<std::uint8_t>(random.Next() % 12);
  }

  double At(const std::array<double, 3>& at) const {
    std::array<int, 3> cell;
    std::array<double, 3> f;
    std::array<double, 3> fade;
    for (std::size_t a = 0; a < 3; ++a) {
      cell[a] = static_cast<int>(at[a]);
      f[a] = at[a] - cell[a];
      fade[a] = f[a] * f[a] * f[a] * (f[a] * (f[a] * 6.0 - 15.0) + 10.0);
    }
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> up = {corner & 1, (corner >> 1) & 1, corner >> 2};
      double weight = 1.0;
      for (std::size_t a = 0; a < 3; ++a) weight *= up[a] != 0 ? fade[a] : 1.0 - fade[a];
      sum += weight * Slope(cell[0] + up[0], cell[1] + up[1], cell[2] + up[2],
                            {f[0] - up[0], f[1] - up[1], f[2] - up[2]});
    }
    return sum;
  }

 private:
  /// Inner product of the lattice point's gradient and the way from it.
  double Slope(int i, int j, int k, const std::array<double, 3>& way) const {
    const auto n =
        static_cast<std::size_t>(((k % cells_) * cells_ + j % cells_) * cells_ + i % cells_);
    const int g = gradient_[n];
    const auto a = static_cast<std::size_t>(g / 4);  // The axis that the gradient does not have.
    const double u = (g & 1) != 0 ? -1.0 : 1.0;
    const double v = (g & 2) != 0 ? -1.0 : 1.0;
    return u * way[(a + 1) % 3] + v * way[(a + 2) % 3];
  }

  int cells_;
  std::vector<std::uint8_t> gradient_;
};

}  // namespace

NoiseTile NoiseTile::White(std::string_view name, std::uint64_t seed) {
  NoiseTile tile;
  RandomStream random(seed, name);
  for (int row = 0; row < kSize * kSize; ++row) {
    for (int i = 0; i < kSize; ++i) {
      tile.bytes_[static_cast<std::size_t>(row * kRow + i)] =
          static_cast<std::uint8_t>(random.Next() >> 56);
    }
  }
  tile.CloseRows();
  return tile;
}

NoiseTile NoiseTile::Perlin(int voxels_per_cell, int octaves, std::string_view name,
                            std::uint64_t seed) {
  ACUS_REQUIRE(
      octaves >= 1 && voxels_per_cell >= 2 << (octaves - 1) && kSize % voxels_per_cell == 0,
      "gradient noise: ", octaves, " octaves in cells of ", voxels_per_cell,
      " voxels; the finest octave needs 2 voxels a cell");
  std::vector<GradientNoise> noises;
  double amplitude_sum = 0.0;
  for (int o = 0; o < octaves; ++o) {
    noises.emplace_back((kSize / voxels_per_cell) << o, name, static_cast<std::uint64_t>(o), seed);
    amplitude_sum += std::ldexp(1.0, -o);
  }
  NoiseTile tile;
  for (int k = 0; k < kSize; ++k) {
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < kSize; ++i) {
        double sum = 0.0;
        for (int o = 0; o < octaves; ++o) {
          const double scale = static_cast<double>(1 << o) / voxels_per_cell;
          sum += std::ldexp(
              noises[static_cast<std::size_t>(o)].At({i * scale, j * scale, k * scale}), -o);
        }
        const double byte = std::round(127.5 + 127.5 * sum / amplitude_sum);
        tile.bytes_[static_cast<std::size_t>((k * kSize + j) * kRow + i)] =
            static_cast<std::uint8_t>(std::clamp(byte, 0.0, 255.0));
      }
    }
  }
  tile.CloseRows();
  return tile;
}

void NoiseTile::CloseRows() {
  for (int row = 0; row < kSize * kSize; ++row) {
    bytes_[static_cast<std::size_t>(row * kRow + kSize)] =
        bytes_[static_cast<std::size_t>(row * kRow)];
  }
}

void NoiseTile::Row(const slicing::kernels::Lines& lines, float sample,
                    const float tile_per_index[3], int lanes, float* out) const {
  HWY_DYNAMIC_DISPATCH(TileRow)(bytes_.data(), kRow, lines, sample, tile_per_index, lanes, out);
}

float NoiseTile::At(int i, int j, int k) const {
  constexpr int kMask = kSize - 1;
  const int row = (k & kMask) * kSize + (j & kMask);
  return static_cast<float>(bytes_[static_cast<std::size_t>(row * kRow + (i & kMask))]) / 255.0F;
}

}  // namespace acus::ultrasound
#endif  // HWY_ONCE
