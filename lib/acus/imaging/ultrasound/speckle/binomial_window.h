// Smoothing by the binomial window 1 4 6 4 1: one voxel of standard deviation.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace acus::ultrasound {

/// Voxels on each side of the middle.
inline constexpr int kBinomialReach = 2;
inline constexpr std::array<float, 5> kBinomial{1.0F / 16, 4.0F / 16, 6.0F / 16, 4.0F / 16,
                                                1.0F / 16};

/// Smooths a slice of nx x ny values along x and y, in place. Beyond the slice lies its edge.
/// @param scratch  Kept between calls, so that only the first allocates.
void SmoothSlice(std::vector<float>& slice, int nx, int ny, std::vector<float>& scratch);

/// out[n] = the window's sum of five slices at n.
void SmoothAcrossSlices(const std::array<const float*, 5>& slices, std::size_t count, float* out);

/// Where slice `k` (from -kBinomialReach on) is kept in a ring of five.
constexpr std::size_t RingSlot(int k) {
  return static_cast<std::size_t>((k + 5) % 5);
}

/// Smooths across the slices around `k` of a ring. @param slice_at  Its values by slot.
template <typename SliceAt>
void SmoothRing(int k, const SliceAt& slice_at, std::vector<float>& out) {
  std::array<const float*, 5> slices;
  for (int t = 0; t < 5; ++t) {
    slices[static_cast<std::size_t>(t)] = slice_at(RingSlot(k + t - kBinomialReach)).data();
  }
  SmoothAcrossSlices(slices, out.size(), out.data());
}

}  // namespace acus::ultrasound
