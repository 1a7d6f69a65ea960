// Light on samples of rays, as many at a time as a vector holds. Included once for each instruction
// set: hence no ordinary include guard.
#if defined(ACUS_VOLUME_RENDERING_RAY_SHADING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACUS_VOLUME_RENDERING_RAY_SHADING_INL_H
#undef ACUS_VOLUME_RENDERING_RAY_SHADING_INL_H
#else
#define ACUS_VOLUME_RENDERING_RAY_SHADING_INL_H
#endif

#include <hwy/highway.h>

#include "acus/imaging/volume_rendering/ray_sampling-inl.h"

HWY_BEFORE_NAMESPACE();
namespace acus::volume_rendering::kernels::HWY_NAMESPACE {

// x, y, z and one more of two voxels beside each other (GCC and Clang).
using SlopePair = float __attribute__((vector_size(32)));
using StoredSlopes = std::int8_t __attribute__((vector_size(8)));
using WideSlopes = std::int16_t __attribute__((vector_size(16)));

HWY_INLINE void LoadSlopes(const std::int8_t* voxel, SlopePair& out) {
  StoredSlopes stored;
  std::memcpy(&stored, voxel, sizeof(stored));
  out = __builtin_convertvector(__builtin_convertvector(stored, WideSlopes), SlopePair);
}

/// Slopes of the HU in CT space, HU/mm, trilinear, of the first places of a vector.
/// @param voxel  Of their cells.
HWY_INLINE void SlopesAt(const RayScene& scene, const std::int32_t* voxel,
                         const float (*share)[4 * kLanes], int count, VF* slope) {
  const F f;
  const std::ptrdiff_t to_row = 2 * static_cast<std::ptrdiff_t>(scene.ct.row_bytes);
  const std::ptrdiff_t to_slice = 2 * static_cast<std::ptrdiff_t>(scene.ct.slice_bytes);
  alignas(64) float values[4 * kLanes] = {};
  for (int n = 0; n < count; ++n) {
    const std::int8_t* corner = scene.slopes + 4 * static_cast<std::ptrdiff_t>(voxel[n]);
    SlopePair near;
    SlopePair near_row;
    SlopePair far;
    SlopePair far_row;
    LoadSlopes(corner, near);
    LoadSlopes(corner + to_row, near_row);
    LoadSlopes(corner + to_slice, far);
    LoadSlopes(corner + to_slice + to_row, far_row);
    near += share[1][n] * (near_row - near);
    far += share[1][n] * (far_row - far);
    near += share[2][n] * (far - near);
    const VF4 left = __builtin_shufflevector(near, near, 0, 1, 2, 3);
    const VF4 right = __builtin_shufflevector(near, near, 4, 5, 6, 7);
    const VF4 value = left + share[0][n] * (right - left);
    std::memcpy(values + 4 * n, &value, sizeof(value));
  }
  VF along[4];
  hn::LoadInterleaved4(f, values, along[0], along[1], along[2], along[3]);
  for (int a = 0; a < 3; ++a) {
    VF turn[3];
    for (int b = 0; b < 3; ++b) {
      turn[b] = hn::Set(f, scene.slope_unit * scene.ct_from_slope[3 * a + b]);
    }
    slope[a] = Dot(turn, along);
  }
}

/// See Shade in shading.h. @return how bright the colour is; and the gloss on it.
HWY_INLINE VF Brightness(const Lamp& lamp, const VF* normal, const VF* ray, VF lit, VF& gloss) {
  const F f;
  const VF zero = hn::Zero(f);
  VF to_lamp[3];
  VF half[3];
  for (int a = 0; a < 3; ++a) {
    to_lamp[a] = hn::Set(f, lamp.to_lamp[a]);
    half[a] = hn::Sub(to_lamp[a], ray[a]);
  }
  const VF backward = Dot(normal, ray);
  // Both sides are lit alike.
  const VF toward_eye = hn::Abs(backward);
  const auto away = hn::Gt(backward, zero);
  const auto faced = [&](VF value) HWY_ATTR {
    return hn::Max(hn::IfThenElse(away, hn::Sub(zero, value), value), zero);
  };
  const VF toward_lamp = faced(Dot(normal, to_lamp));
  const VF length = hn::Max(hn::Sqrt(Dot(half, half)), hn::Set(f, 1e-12F));
  VF shine = hn::Div(faced(Dot(normal, half)), length);
  for (int n = 0; n < 5; ++n) shine = hn::Mul(shine, shine);  // To the 32nd.
  gloss = hn::Mul(hn::Mul(lit, hn::Set(f, lamp.gloss)), shine);
  return hn::Add(hn::Add(hn::Set(f, lamp.ambient), hn::Mul(hn::Set(f, lamp.fill), toward_eye)),
                 hn::Mul(hn::Mul(lit, hn::Set(f, lamp.diffuse)), toward_lamp));
}

/// Samples that wait for their light, in the order in which they were met.
struct ShadeQueue {
  static constexpr int kRoom = 4 * kLanes;
  int count = 0;
  alignas(64) float colour[3][kRoom] = {};
  alignas(64) std::int32_t voxel[kRoom] = {};  ///< The first of a cell ...
  alignas(64) float share[3][kRoom] = {};      ///< ... and the place in it.
  alignas(64) float at_mm[kRoom] = {};
  alignas(64) float weight[kRoom] = {};
  alignas(64) std::int32_t ray[kRoom] = {};

  HWY_INLINE void Push(const RayScene& scene, std::uint32_t lanes, const VF* of_colour,
                       const VF* index, const float* at, const float* of_weight,
                       const std::int32_t* of_ray) {
    const F f;
    const I d;
    const auto mask = FromBits(d, lanes);
    const auto mask_f = hn::RebindMask(f, mask);
    VF of_share[3];
    const VI of_voxel = CellAt(scene.ct, index, of_share);
    hn::StoreU(hn::Compress(of_voxel, mask), d, voxel + count);
    for (int a = 0; a < 3; ++a) {
      hn::StoreU(hn::Compress(of_colour[a], mask_f), f, colour[a] + count);
      hn::StoreU(hn::Compress(of_share[a], mask_f), f, share[a] + count);
    }
    hn::StoreU(hn::Compress(hn::Load(f, at), mask_f), f, at_mm + count);
    hn::StoreU(hn::Compress(hn::Load(f, of_weight), mask_f), f, weight + count);
    hn::StoreU(hn::Compress(hn::Load(d, of_ray), mask), d, ray + count);
    const int first = count;
    count += __builtin_popcount(lanes);
    // They will be in the cache when their turn comes.
    const std::ptrdiff_t to_row = 2 * static_cast<std::ptrdiff_t>(scene.ct.row_bytes);
    const std::ptrdiff_t to_slice = 2 * static_cast<std::ptrdiff_t>(scene.ct.slice_bytes);
    for (int n = first; n < count; ++n) {
      const std::int8_t* corner = scene.slopes + 4 * static_cast<std::ptrdiff_t>(voxel[n]);
      __builtin_prefetch(corner);
      __builtin_prefetch(corner + to_row);
      __builtin_prefetch(corner + to_slice);
      __builtin_prefetch(corner + to_slice + to_row);
    }
  }

  /// The first ones, as many as a vector holds, into the colours of their rays.
  HWY_INLINE void Shade(const RayScene& scene, RayHost& host, RayTile& tile) {
    const F f;
    const I d;
    const int lanes = static_cast<int>(hn::Lanes(f));
    const int taken = count < lanes ? count : lanes;
    for (int n = taken; n < lanes; ++n) ray[n] = 0;
    VF direction[3];
    const VI rays = hn::Load(d, ray);
    for (int a = 0; a < 3; ++a) {
      direction[a] = hn::GatherIndex(f, tile.direction[a], rays);
    }
    VF lit = hn::Set(f, 1.0F);
    if (scene.has_shadows) {
      alignas(64) float lit_at[kLanes];
      hn::Store(lit, f, lit_at);
      for (int n = 0; n < taken; ++n) lit_at[n] = host.LitAt(ray[n], at_mm[n]);
      lit = hn::Load(f, lit_at);
    }
    VF slope[3];
    SlopesAt(scene, voxel, share, taken, slope);
    const VF steepness = hn::Sqrt(Dot(slope, slope));
    const VF divisor = hn::Max(steepness, hn::Set(f, 1e-20F));
    for (VF& component : slope) component = hn::Div(component, divisor);
    VF gloss;
    const VF bright = Brightness(scene.lamp, slope, direction, lit, gloss);
    const Lamp& lamp = scene.lamp;
    const VF flat = hn::Set(f, lamp.ambient + 0.5F * (lamp.diffuse + lamp.fill));
    const VF lit_share =
        hn::Min(hn::Set(f, 1.0F), hn::Mul(steepness, hn::Set(f, 1.0F / scene.surface_hu_per_mm)));
    const VF of_colour = Mix(flat, bright, lit_share);
    const VF of_gloss = hn::Mul(lit_share, gloss);
    const VF weights = hn::Load(f, weight);
    alignas(64) float light[3][kLanes];
    for (int c = 0; c < 3; ++c) {
      const VF seen = hn::Add(hn::Mul(hn::Load(f, colour[c]), of_colour), of_gloss);
      hn::Store(hn::Mul(weights, seen), f, light[c]);
    }
    for (int n = 0; n < taken; ++n) {
      for (int c = 0; c < 3; ++c) tile.colour[c][ray[n]] += light[c][n];
    }
    Advance(taken);
  }

  HWY_INLINE void Advance(int taken) {
    count -= taken;
    const F f;
    const I d;
    const int lanes = static_cast<int>(hn::Lanes(f));
    for (int n = 0; n < count; n += lanes) {
      for (int a = 0; a < 3; ++a) {
        hn::StoreU(hn::LoadU(f, colour[a] + taken + n), f, colour[a] + n);
        hn::StoreU(hn::LoadU(f, share[a] + taken + n), f, share[a] + n);
      }
      hn::StoreU(hn::LoadU(f, at_mm + taken + n), f, at_mm + n);
      hn::StoreU(hn::LoadU(f, weight + taken + n), f, weight + n);
      hn::StoreU(hn::LoadU(d, ray + taken + n), d, ray + n);
      hn::StoreU(hn::LoadU(d, voxel + taken + n), d, voxel + n);
    }
  }
};

}  // namespace acus::volume_rendering::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
