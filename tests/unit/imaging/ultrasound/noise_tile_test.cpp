#include "acus/imaging/ultrasound/speckle/noise_tile.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

constexpr int kLanes = 16;

/// Noise at one place, in voxels of the tile.
float At(const NoiseTile& tile, double i, double j, double k) {
  alignas(64) float start[3][kLanes];
  alignas(64) float step[3][kLanes] = {};
  alignas(64) float out[kLanes];
  const double at[3] = {i, j, k};
  slicing::kernels::Lines lines{};
  for (int a = 0; a < 3; ++a) {
    std::fill_n(start[a], kLanes, static_cast<float>(at[a]));
    lines.start[a] = start[a];
    lines.step[a] = step[a];
  }
  const float one[3] = {1.0F, 1.0F, 1.0F};
  tile.Row(lines, 0.0F, one, kLanes, out);
  EXPECT_EQ(out[0], out[kLanes - 1]);
  return out[0];
}

TEST(NoiseTile, IsTrilinearBetweenVoxelsAndRepeatsWithoutSeam) {
  const NoiseTile tile = NoiseTile::White("test");
  for (const int i : {0, 5, 127, -1, 128, -129}) {
    EXPECT_FLOAT_EQ(At(tile, i, 3, 7), tile.At(i, 3, 7)) << i;
    EXPECT_FLOAT_EQ(At(tile, 3, i, 7), tile.At(3, i, 7)) << i;
    EXPECT_FLOAT_EQ(At(tile, 3, 7, i), tile.At(3, 7, i)) << i;
    EXPECT_NEAR(At(tile, i + 0.25, 3, 7), 0.75 * tile.At(i, 3, 7) + 0.25 * tile.At(i + 1, 3, 7),
                1e-6);
    EXPECT_NEAR(At(tile, 3, i + 0.25, 7), 0.75 * tile.At(3, i, 7) + 0.25 * tile.At(3, i + 1, 7),
                1e-6);
    EXPECT_NEAR(At(tile, 3, 7, i + 0.25), 0.75 * tile.At(3, 7, i) + 0.25 * tile.At(3, 7, i + 1),
                1e-6);
  }
  EXPECT_EQ(tile.At(0, 0, 0), tile.At(128, -128, 256));
}

TEST(NoiseTile, WhiteNoiseIsUniformAndWithoutMemory) {
  const NoiseTile tile = NoiseTile::White("test");
  double sum = 0.0;
  double square = 0.0;
  double lagged = 0.0;
  constexpr int kCount = 64 * 64 * 64;
  for (int n = 0; n < kCount; ++n) {
    const int i = n % 64;
    const int j = n / 64 % 64;
    const int k = n / 4096;
    const double value = tile.At(i, j, k) - 0.5;
    sum += value;
    square += value * value;
    lagged += value * (tile.At(i + 1, j, k) - 0.5);
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.003);
  EXPECT_NEAR(std::sqrt(square / kCount), 1.0 / std::sqrt(12.0), 0.003);
  EXPECT_NEAR(lagged / square, 0.0, 0.01);
}

// Gradient noise is 0 at its lattice points and made of waves about two cells long.
TEST(NoiseTile, PerlinNoiseIsZeroOnItsLatticeAndBandLimited) {
  constexpr int kCell = 8;
  const NoiseTile tile = NoiseTile::Perlin(kCell, 1, "test");
  double square = 0.0;
  double near = 0.0;
  double far = 0.0;
  for (int k = 0; k < NoiseTile::kSize; k += 3) {
    for (int j = 0; j < NoiseTile::kSize; ++j) {
      for (int i = 0; i < NoiseTile::kSize; ++i) {
        const double value = tile.At(i, j, k) - 0.5;
        square += value * value;
        near += value * (tile.At(i + 1, j, k) - 0.5);
        far += value * (tile.At(i + 3 * kCell, j, k) - 0.5);
      }
    }
  }
  for (const int i : {0, kCell, 5 * kCell}) EXPECT_NEAR(tile.At(i, 2 * kCell, 0), 0.5, 0.002);
  EXPECT_GT(near / square, 0.85);
  EXPECT_NEAR(far / square, 0.0, 0.03);
}

TEST(NoiseTile, FurtherOctavesAddFinerGrain) {
  const auto roughness = [](const NoiseTile& tile) {
    double square = 0.0;
    double step = 0.0;
    for (int j = 0; j < NoiseTile::kSize; ++j) {
      for (int i = 0; i < NoiseTile::kSize; ++i) {
        const double value = tile.At(i, j, 5) - 0.5;
        const double rise = tile.At(i + 1, j, 5) - tile.At(i, j, 5);
        square += value * value;
        step += rise * rise;
      }
    }
    return step / square;
  };
  EXPECT_GT(roughness(NoiseTile::Perlin(16, 2, "a")),
            1.5 * roughness(NoiseTile::Perlin(16, 1, "a")));
  EXPECT_THROW(NoiseTile::Perlin(4, 3, "too fine"), InputError);
  EXPECT_THROW(NoiseTile::Perlin(7, 1, "no seamless lattice"), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
