// Places of bent lines, a row at a time, in vector instructions: two of the kernels (kernels.h).
#pragma once

namespace acus::slicing::kernels {

/// One axis of a row of knots. Cells of lanes lie between knots.
struct KnotRow {
  const int* knot;      ///< Lane of each knot, ascending, from 0.
  int cells;            ///< Between the knots; the last continues to the end.
  const float* weight;  ///< By lane: share of the knot after it.
  const float* offset;  ///< By knot.
};
/// out[l] = offset, linear between the knots around lane l.
void SpreadRow(const KnotRow& row, int lanes, float* out);

/// One axis of a row of bent lines, by lane. `above` and `below` are the offsets at the rows of
/// knots around it, `down` the share of the latter.
struct BentRow {
  const float* start;  ///< Of the straight line.
  const float* step;   ///< From sample to sample.
  float sample;        ///< Number of this row.
  const float* above;
  const float* below;
  float down;
};
/// out = start + sample * step + offset.
void BendRow(const BentRow& row, int lanes, float* out);

}  // namespace acus::slicing::kernels
