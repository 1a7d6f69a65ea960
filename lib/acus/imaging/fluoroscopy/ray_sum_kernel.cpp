#include "acus/imaging/fluoroscopy/ray_sum_kernel.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/fluoroscopy/ray_sum_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::fluoroscopy::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;

/// Values at a and a + 1 lie side by side: one 32-bit load fetches both.
HWY_INLINE VF LerpPair(const std::int32_t* data, VI byte_offset, VF fraction) {
  const F f;
  const VI pair = hn::GatherOffset(I(), data, byte_offset);
  const VF low = hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)));
  const VF high = hn::ConvertTo(f, hn::ShiftRight<16>(pair));
  return hn::Add(low, hn::Mul(fraction, hn::Sub(high, low)));
}

void RaySums(const Slices& slices, const RayTile& rays, int first, int end, float* sum) {
  const F f;
  const I d;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const VF last_a = hn::Set(f, slices.last_a);
  const VF last_b = hn::Set(f, slices.last_b);
  const VF low_a = hn::Set(f, slices.last_a - 1.0F);
  const VF low_b = hn::Set(f, slices.last_b - 1.0F);
  const VI row = hn::Set(d, slices.row_bytes);
  for (int r = 0; r < RayTile::kRays; r += lanes) hn::Store(hn::Zero(f), f, sum + r);
  for (int n = first; n < end; ++n) {
    const auto* slice = reinterpret_cast<const std::int32_t*>(slices.data + n * slices.elements);
    const VF number = hn::Set(f, static_cast<float>(n));
    for (int r = 0; r < RayTile::kRays; r += lanes) {
      const VF a =
          hn::Add(hn::Load(f, rays.start[0] + r), hn::Mul(number, hn::Load(f, rays.step[0] + r)));
      const VF b =
          hn::Add(hn::Load(f, rays.start[1] + r), hn::Mul(number, hn::Load(f, rays.step[1] + r)));
      // Beyond the border of zeros the nearest zero stands for what is not there.
      const VF in_a = hn::Min(hn::Max(a, hn::Zero(f)), last_a);
      const VF in_b = hn::Min(hn::Max(b, hn::Zero(f)), last_b);
      const VF cell_a = hn::Min(hn::Floor(in_a), low_a);
      const VF cell_b = hn::Min(hn::Floor(in_b), low_b);
      const VF fraction_a = hn::Sub(in_a, cell_a);
      const VF fraction_b = hn::Sub(in_b, cell_b);
      const VI near = hn::Add(hn::ShiftLeft<1>(hn::ConvertTo(d, cell_a)),
                              hn::Mul(hn::ConvertTo(d, cell_b), row));
      const VF v0 = LerpPair(slice, near, fraction_a);
      const VF v1 = LerpPair(slice, hn::Add(near, row), fraction_a);
      const VF value = hn::Add(v0, hn::Mul(fraction_b, hn::Sub(v1, v0)));
      hn::Store(hn::Add(hn::Load(f, sum + r), value), f, sum + r);
    }
  }
}

}  // namespace acus::fluoroscopy::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::fluoroscopy::kernels {

HWY_EXPORT(RaySums);

void RaySums(const Slices& slices, const RayTile& rays, int first, int end, float* sum) {
  HWY_DYNAMIC_DISPATCH(RaySums)(slices, rays, first, end, sum);
}

}  // namespace acus::fluoroscopy::kernels
#endif
