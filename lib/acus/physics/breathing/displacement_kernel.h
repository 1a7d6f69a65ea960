// Displacements of many points at once, in vector instructions chosen at run time (Highway). Every
// point does the same IEEE operations in the same order, without fused multiply-add: the same bits
// on SSE, AVX2 and AVX-512, whichever points stand beside it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace acus::breathing::kernels {

/// A MotionField at a moment.
struct FieldNow {
  static constexpr int kMaxComponents = 4;
  int num_components = 0;
  const std::int16_t* values[kMaxComponents] = {};  ///< x, y, z of each node, i fastest.
  float unit_mm[kMaxComponents] = {};
  std::ptrdiff_t row = 0;       ///< Values from j to j + 1.
  std::ptrdiff_t slice = 0;     ///< Values from k to k + 1.
  float last[3] = {};           ///< Highest index along i, j, k.
  float index_from_ct[9] = {};  ///< By rows.
  float index_offset[3] = {};
};

/// Points in CT space, x, y, z of one after the other as in a Matrix3Xf.
/// displacement_mm.col(n) = u(rest_mm.col(n)). The two may be the same memory.
void Displacements(const FieldNow& field, const float* rest_mm, int count, float* displacement_mm);

/// world_mm.col(n) = rest_mm.col(n) + u, and normals turned along: those of the deformed surface,
/// by the cofactor of I + grad u, unit again. Where the field folds them flat, as at rest.
void MoveWithNormals(const FieldNow& field, const float* rest_mm, const float* rest_normals,
                     int count, float* world_mm, float* normals);

}  // namespace acus::breathing::kernels
