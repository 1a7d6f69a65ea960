// Places of bent lines, a row at a time, in vector instructions: one of the kernels (kernels.h).
#pragma once

namespace acus::slicing::kernels {

/// One axis of a row of bent lines. Cells of lanes lie between knots; `above` and `below` are the
/// offsets at the knots of the rows around, `down` the share of the latter.
struct BentRow {
  const float* start;   ///< Of the straight line, by lane.
  const float* step;    ///< From sample to sample.
  float sample;         ///< Number of this row.
  const int* knot;      ///< Lane of each knot, ascending.
  int cells;            ///< Between the knots; the last goes on to the end.
  const float* weight;  ///< By lane: share of the knot after it.
  const float* above;
  const float* below;
  float down;
};
/// out[l - first] = start[l] + sample * step[l] + offset(l) for lanes [first, first + count), whose
/// first lies in `cell`.
void BendRow(const BentRow& row, int cell, int first, int count, float* out);

}  // namespace acus::slicing::kernels
