// Noise that is fixed in space: a cube of grey values, repeated without seams.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound {

/// 128 voxels a side, values from 0 to 1 in steps of 1/255, trilinear in between. The same bits
/// with any vector width.
class NoiseTile {
 public:
  static constexpr int kLog2Size = 7;
  static constexpr int kSize = 1 << kLog2Size;

  /// Every voxel drawn by itself, uniformly: Vidal's stack of noisy slices.
  static NoiseTile White(std::string_view name, std::uint64_t seed = 0);

  /// Gradient noise on lattices of kSize / `voxels_per_cell` cells a side and, for each further
  /// octave, twice that many at half the amplitude. 0.5 is its mean.
  /// @throws InputError if the finest lattice would have less than two voxels per cell.
  static NoiseTile Perlin(int voxels_per_cell, int octaves, std::string_view name,
                          std::uint64_t seed = 0);

  /// out[l] = noise at the voxel index of each lane (of the CT) times tile_per_index.
  void Row(const slicing::kernels::Lines& lines, float sample, const float tile_per_index[3],
           int lanes, float* out) const;

  /// Noise of one voxel; indices are taken modulo kSize.
  float At(int i, int j, int k) const;

 private:
  NoiseTile() : bytes_(kSize * kSize * kRow + 4) {}
  void CloseRows();

  static constexpr int kRow = kSize + 1;  ///< The first voxel again, so that pairs lie together.
  std::vector<std::uint8_t> bytes_;       ///< Index (k * kSize + j) * kRow + i; 4 more may be read.
};

}  // namespace acus::ultrasound
