// The inner loops of the beam renderer, in vector instructions chosen at run time (Highway).
//
// Rows hold one value per scan line, aligned to 64 bytes, and may be written up to the next
// multiple of kBlock lanes. Where a decision hangs on a value (which voxel, is this an interface)
// there is no fused multiply-add: all instruction sets decide alike. FilterAcrossRow and
// FilterAlongRow fuse where the machine can; their results differ by rounding only.
#pragma once

#include <cstdint>

#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound::kernels {

using slicing::kernels::kBlock;
using slicing::kernels::Lines;
using slicing::kernels::RoundUp;

/// Labels for LabelRow, one byte each; at least four voxels in all.
struct LabelVoxels {
  const std::uint8_t* data;
  std::int32_t last_word;    ///< Number of voxels - 4: the last four bytes that can be loaded.
  float edge[3];             ///< Positions from -0.5 to this (size - 0.5) are inside.
  std::int32_t row_bytes;    ///< From j to j + 1.
  std::int32_t slice_bytes;  ///< From k to k + 1.
};

/// Stands for a label outside the volume.
inline constexpr std::int32_t kNotScannedLabel = -1;

/// label[l] = label of the voxel nearest to sample `s` of each lane; kNotScannedLabel outside.
void LabelRow(const LabelVoxels& voxels, const Lines& lines, float s, int lanes,
              std::int32_t* label);

/// What the echo is computed from, for one row of samples.
struct TissueRow {
  float* log_impedance;  ///< zeta = ln(Z / MRayl) / 2: R = tanh of its step across an interface.
  float* decay;          ///< Amplitude left after one sample, two-way.
  float* scatter;        ///< Amplitude of the speckle (root mean square of the envelope).
};

/// Tables with one entry for each of the 256 labels.
struct LabelTables {
  const float* log_impedance;
  const float* decay;
  const float* scatter;
};
void TissueOfLabelRow(const LabelTables& tables, const std::int32_t* label, int lanes,
                      const TissueRow& out);

/// Three curves over HU with common knots; the middle one gives nepers per sample.
struct TissueCurves {
  static constexpr int kMaxKnots = 16;
  int num_knots = 0;
  float hu_knot[kMaxKnots] = {};
  float first_value[3] = {};
  float slope_change[3][kMaxKnots] = {};
};
void TissueOfHuRow(const TissueCurves& curves, const float* hu, int lanes, const TissueRow& out);

/// Follows runs of zeta that rise (or fall) without a break, each of which is one interface.
struct InterfaceRow {
  const float* log_impedance;  ///< Of this row.
  float* previous;             ///< Of the row before.
  float* start;                ///< Where the run began.
  float* moment;               ///< Sum of (step * place) over the run.
  float* run;                  ///< Out: whole step of a run that ended before this row; else 0.
  float* place;                ///< Out: sample number of its middle.
  float k;                     ///< Number of this row.
  float min_step;              ///< Flatter than this per sample is no interface.
  float min_run;               ///< Smaller than this altogether is none either.
};
/// Returns whether any run ended here.
bool FindInterfacesRow(const InterfaceRow& row, int lanes);

/// Speckle from random complex numbers at the points of a cubic lattice that is fixed to the
/// tissue, interpolated over tetrahedra with weights of constant sum of squares: variance 1
/// everywhere.
struct SpeckleRow {
  Lines lattice;         ///< Positions in lattice units.
  const float* scatter;  ///< Amplitude of each lane.
  const float* decay;
  const float* energy;  ///< Amplitude that arrives.
  float* energy_after;  ///< Out: energy * decay.
  float gain;
  float* re;
  float* im;
  /// Phase of a steered line (LookPhase), the product of two unit numbers; null: none.
  const float* turn_of_lane[2] = {nullptr, nullptr};  ///< Real and imaginary part of each lane ...
  float turn_of_row[2] = {1.0F, 0.0F};                ///< ... and of this row.
};
/// re, im = energy * scatter * gain * noise [* turn]; `add`: added to what is there.
void SpeckleEchoRow(const SpeckleRow& row, float s, int lanes, bool add);

/// after = energy * decay.
void DecayRow(const float* energy, const float* decay, int lanes, float* after);

/// Takes `other` where the label is 0.
void FillUnlabelledRow(const std::int32_t* label, const TissueRow& other, int lanes,
                       const TissueRow& out);

/// out[l] = weight[0] * rows[half][l] + sum over t of weight[t] * (rows[half-t][l] +
/// rows[half+t][l])
void FilterAlongRow(const float* const* rows, const float* weight, int half, int lanes, float* out);

/// intensity[l] = |c|^2, c = symmetric window over (re, im)[l - half ... l + half].
void FilterAcrossRow(const float* re, const float* im, const float* weight, int half, int lanes,
                     float* intensity);

/// grey[l] = round(offset + scale * log2(intensity[l])), cut off to 0 ... 255.
void GreyRow(const float* intensity, float offset, float scale, int lanes, std::uint8_t* grey);

/// A row of an image whose columns read between lines: out[l] = bilinear in rows `upper` and
/// `lower` at byte column[l] and the one after it.
struct ColumnsRow {
  const std::uint8_t* upper;
  const std::uint8_t* lower;
  const std::int32_t* column;
  const float* across;  ///< Fraction towards the next byte.
  float along;          ///< Fraction towards `lower`.
};
void ResampleColumnsRow(const ColumnsRow& row, int lanes, std::uint8_t* out);

/// As InterpolateRow, with both fractions in one number: across + 256 * along, in 256ths.
void InterpolatePackedRow(const std::uint8_t* image, std::int32_t stride,
                          const std::int32_t* offset, const std::uint16_t* fractions, int lanes,
                          std::uint8_t* out);

}  // namespace acus::ultrasound::kernels
