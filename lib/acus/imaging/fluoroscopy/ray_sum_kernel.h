// The inner loop of fluoroscopy: sums along rays through the slices of a volume, in vector
// instructions chosen at run time (Highway). The same bits with any vector width.
#pragma once

#include <cstddef>
#include <cstdint>

namespace acus::fluoroscopy::kernels {

/// Slices of values >= 0, each with a border of zeros: beyond it the volume is empty.
struct Slices {
  const std::int16_t* data;
  float last_a;  ///< Highest index along a, which runs fastest.
  float last_b;
  std::int32_t row_bytes;   ///< From b to b + 1.
  std::ptrdiff_t elements;  ///< From one slice to the next.
};

/// A tile of rays: ray r meets slice n at (start[0][r] + n * step[0][r], start[1][r] + n *
/// step[1][r]). Aligned to 64 bytes.
struct RayTile {
  static constexpr int kRays = 128;
  alignas(64) float start[2][kRays];
  alignas(64) float step[2][kRays];
};

/// sum[r] = sum over slices n in [first, end) of the value where ray r meets them, bilinear
/// (Joseph, IEEE Trans Med Imaging 1(3):192, 1982). `sum`: RayTile::kRays floats, aligned to 64.
void RaySums(const Slices& slices, const RayTile& rays, int first, int end, float* sum);

}  // namespace acus::fluoroscopy::kernels
