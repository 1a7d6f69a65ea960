// The inner loops of the aperture renderer, in vector instructions chosen at run time (Highway).
//
// Every lane does the same IEEE operations in the same order, without fused multiply-add: the same
// bits on all instruction sets. Rows are written up to the next multiple of kBlock lanes.
#pragma once

#include <cstdint>

#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound::kernels {

using slicing::kernels::kBlock;
using slicing::kernels::Lines;
using slicing::kernels::RoundUp;

/// Acoustic properties of a box of voxels, packed: 12 bits of zeta, 10 of loss, 10 of scatter.
/// Each axis of the box has at least two voxels.
struct AcousticVoxels {
  const std::uint32_t* data;
  float first[3];             ///< Voxel index of the box's first voxel.
  float last[3];              ///< Highest index within the box, from its first voxel.
  float edge[3];              ///< Positions from -0.5 to this are in the grid.
  std::int32_t row_voxels;    ///< From j to j + 1.
  std::int32_t slice_voxels;  ///< From k to k + 1.
  float zeta_first;           ///< zeta = zeta_first + zeta_unit * code.
  float zeta_unit;
  float nepers_unit;  ///< Two-way nepers of amplitude per mm = nepers_unit * code.
  float scatter_unit;
};

inline constexpr std::uint32_t kZetaCodes = 4096;
inline constexpr std::uint32_t kNepersCodes = 1024;
inline constexpr std::uint32_t kScatterCodes = 1024;

/// One row of samples, trilinear. Beyond the box: its nearest voxel. Beyond the grid there is no
/// patient: seen is 0 there, 1 elsewhere.
struct AcousticRow {
  float* zeta;
  float* nepers;
  float* scatter;
  float* seen;
};
void SampleAcousticRow(const AcousticVoxels& voxels, const Lines& lines, float s, int lanes,
                       const AcousticRow& out);

/// Amplitude left, one way, after one row: adds weight * exp(-nepers) to `left` and
/// weight * scatter^2 to `scatter2`. Bone and gas lose `strong` more, by how far zeta is theirs.
struct LossRow {
  const float* zeta;
  const float* nepers;  ///< Two-way, per mm.
  const float* scatter;
  const float* seen;
  float step_mm;
  float strong_nepers;  ///< Two-way, per mm.
  float weight;
  bool add;  ///< Else `left` and `scatter2` are written.
  float* left;
  float* scatter2;
};
void AddLossRow(const LossRow& row, int lanes);

/// One ray direction, one row deeper. Rays are numbered by the line at which they start; at this
/// row ray r is at line r + shift. ray[r] *= left there, and arriving[l] += weight * ray at line l.
/// `left` is read from -margin to lanes + margin, `ray` likewise; |shift| < margin - 1.
struct RayRow {
  const float* left;
  float* ray;
  float* arriving;
  float shift;
  float weight;
  int margin;
};
void MarchRayRow(const RayRow& row, int lanes);

/// out = a + share * (b - a)
void LerpRow(const float* a, const float* b, float share, int lanes, float* out);

/// out += scale * in. `in` need not be aligned.
void AddScaledRow(const float* in, float scale, int lanes, float* out);

/// out = amplitude^2 * square
void SquareRow(const float* amplitude, const float* square, int lanes, float* out);

/// intensity = sqrt(intensity + share * more). `more` need not be aligned.
void AddRootRow(const float* more, float share, int lanes, float* intensity);

}  // namespace acus::ultrasound::kernels
