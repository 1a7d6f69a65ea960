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

/// What one component of a field is at points of a surface that follow each other: u [mm], and its
/// derivatives along the two tangents that belong to each normal. In 16 bits, so that a moment
/// reads little memory; the units are those of the largest value of the block.
struct SurfaceBlock {
  static constexpr int kPoints = 16;
  static constexpr int kRows = 9;  ///< x, y, z of u, of its derivative along both tangents.
  std::int16_t values[kRows][kPoints];
  float mm_per_unit;
  float slope_per_unit;
};

/// @param field  One component, with its unit alone.
/// @param blocks  One for each kPoints points, the last one filled up with zeros.
void LookUpSurface(const FieldNow& field, const float* rest_mm, const float* rest_normals,
                   int count, SurfaceBlock* blocks);

/// The components of an instant at a surface.
struct SurfaceNow {
  int num_components = 0;
  const SurfaceBlock* blocks[FieldNow::kMaxComponents] = {};  ///< From LookUpSurface.
  float weight[FieldNow::kMaxComponents] = {};
};

/// world_mm.col(n) = rest_mm.col(n) + u, and normals turned along: across both tangents as they
/// are now, unit again. Where the field folds them flat, as at rest.
void MoveSurface(const SurfaceNow& surface, const float* rest_mm, const float* rest_normals,
                 int count, float* world_mm, float* normals);

}  // namespace acus::breathing::kernels
