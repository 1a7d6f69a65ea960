// Means along short lines in an image of lines and samples, in vector instructions chosen at run
// time. The same bits with all of them.
#pragma once

#include <cstdint>

namespace acus::ultrasound::kernels {

/// value(line, sample) = data[sample * stride + line].
struct BlurredPlane {
  const float* data;
  std::int32_t stride;
  std::int32_t lines;    ///< At least 2.
  std::int32_t samples;  ///< At least 2.
};

/// The mean of 2 * taps + 1 values, bilinear, at (line + t * lines_per_tap, sample + t *
/// samples_per_tap) for t from -taps to taps. Places beyond the plane are those at its edge.
float MeanAlong(const BlurredPlane& plane, float line, float sample, float lines_per_tap,
                float samples_per_tap, int taps);

}  // namespace acus::ultrasound::kernels
