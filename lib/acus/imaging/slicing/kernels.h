// The inner loops of the image, in vector instructions chosen at run time (Highway).
//
// Every lane does the same IEEE operations in the same order, without fused multiply-add: the same
// bits on SSE, AVX2 and AVX-512. All rows are aligned to 64 bytes and may be written up to the next
// multiple of 16 lanes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace acus::slicing::kernels {

/// Lanes per block: all counts of lanes are rounded up to it.
inline constexpr int kBlock = 16;
inline constexpr int RoundUp(int lanes) {
  return (lanes + kBlock - 1) / kBlock * kBlock;
}

/// Voxels for SampleRow. Each axis has at least two.
struct Voxels {
  const std::int16_t* data;
  float last[3];             ///< Highest index along i, j, k.
  float edge[3];             ///< Positions from -0.5 to this are inside.
  std::int32_t row_bytes;    ///< From j to j + 1.
  std::int32_t slice_bytes;  ///< From k to k + 1.
  float outside;             ///< Value of all other positions.
};

/// Lines in voxel indices: position of sample s of lane l along axis a = start[a][l] + s *
/// step[a][l].
struct Lines {
  const float* start[3];
  const float* step[3];
};

/// out[l] = volume at sample `s` of each lane in [0, lanes), trilinear.
void SampleRow(const Voxels& voxels, const Lines& lines, float s, int lanes, float* out);

/// A continuous curve over HU: first_value + sum of slope_change[n] * max(0, hu - hu_knot[n]).
struct Curve {
  static constexpr int kMaxKnots = 16;
  int num_knots = 0;
  float first_value = 0.0F;
  float hu_knot[kMaxKnots] = {};
  float slope_change[kMaxKnots] = {};
};

/// out[l] = curve(hu[l]).
void CurveRow(const Curve& curve, const float* hu, int lanes, float* out);

/// Constants of one row of reflection and transmission.
struct EchoRow {
  float share_per_sample;    ///< 1 / samples that an interface spans.
  float threshold;           ///< Reflections above it ...
  float boosted_per_sample;  ///< ... reflect this share per sample.
  float metal_impedance;     ///< Interfaces with a higher impedance ...
  float metal_per_sample;    ///< ... reflect this share per sample.
};

/// Reflection of each lane: r = ((z1 - z0) / (z1 + z0))^2, per sample. Above the threshold: boosted
/// (where there is metal on either side: what metal reflects) if most of the step from z0 to z1 is
/// passed at z, so that a strong line begins at its surface; the threshold's share before.
void ReflectRow(const EchoRow& row, const float* z0, const float* z, const float* z1, int lanes,
                float* reflected);

/// Weights `reflected` by cos^exponent (1 or 2) of the angle between the beam and the HU gradient.
/// `above`, `here`, `below` are HU rows; here[-1] and here[lanes] are read. Spacings as 1 / (2 mm).
struct AngleRow {
  const float* above;
  const float* here;
  const float* below;
  float per_two_axial_mm;
  float per_two_lateral_mm;
  int exponent;
};
void AngleRowWeights(const AngleRow& row, int lanes, float* weight);

/// Echo and what continues: echo = energy * reflected [* weight] [+ energy * scattered];
/// energy *= (1 - reflected)^2. `weight` and `scattered` may be null.
void PropagateRow(const float* reflected, const float* weight, const float* scattered, int lanes,
                  float* energy, float* echo);

/// energy *= exp(-nepers[l]), by the Pade form (2 - x) / (2 + x), which is good to x^3 / 12.
void AttenuateRow(const float* nepers, int lanes, float* energy);

/// Speckle fixed to the CT: scattered[l] *= tile at the position of each lane, a cube of
/// 2^log2_size bytes a side, repeated. tile_per_index scales voxel indices to tile indices.
struct Tile {
  const std::uint8_t* data;  ///< 3 more bytes than the cube may be read.
  int log2_size;
  float per_index[3];
  float unit;  ///< Intensity = (byte * unit)^2.
};
void TextureRow(const Tile& tile, const Lines& lines, float s, int lanes, float* scattered);

/// out[l] = weight[0] * rows[0][l] + sum over t >= 1 of weight[t] * (rows[-t][l] + rows[t][l]),
/// where rows[t] = centre_rows[half + t]: a symmetric window along the beam.
void BlurAlongRow(const float* const* rows, const float* weight, int half, int lanes, float* out);

/// The same across the beams: in[-half] ... in[lanes + half - 1] are read (16 more may be).
void BlurAcrossRow(const float* in, const float* weight, int half, int lanes, float* out);

/// out[l] = round(scale * log2(1 + gain * in[l])), cut off to 0 ... 255. @pre in >= 0.
void CompressRow(const float* in, float gain, float scale, int lanes, std::uint8_t* out);

/// out[l] = round(offset + scale * in[l]), cut off to 0 ... 255.
void WindowRow(const float* in, float offset, float scale, int lanes, std::uint8_t* out);

/// out[l] = bilinear interpolation in `image` at byte offset[l], with neighbours at +1 and +stride;
/// 0 where the offset is negative.
void InterpolateRow(const std::uint8_t* image, std::int32_t stride, const std::int32_t* offset,
                    const float* across, const float* along, int lanes, std::uint8_t* out);

}  // namespace acus::slicing::kernels
