#include "acus/imaging/ultrasound/speckle/blur_kernel.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/ultrasound/speckle/blur_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::ultrasound::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Taps that are summed side by side, whatever the width of a vector: the same sums everywhere.
constexpr int kSideBySide = 16;
using F = hn::CappedTag<float, kSideBySide>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;

HWY_INLINE VF Lerp(VF a, VF b, VF fraction) {
  return hn::Add(a, hn::Mul(fraction, hn::Sub(b, a)));
}

float MeanAlong(const BlurredPlane& plane, float line, float sample, float lines_per_tap,
                float samples_per_tap, int taps) {
  const F f;
  const I d;
  const VF zero = hn::Zero(f);
  const VF last_line = hn::Set(f, static_cast<float>(plane.lines - 1));
  const VF last_sample = hn::Set(f, static_cast<float>(plane.samples - 1));
  const VI last_cell_line = hn::Set(d, plane.lines - 2);
  const VI last_cell_sample = hn::Set(d, plane.samples - 2);
  const VI stride = hn::Set(d, plane.stride);
  const VF last_tap = hn::Set(f, static_cast<float>(taps));
  HWY_ALIGN float sum[kSideBySide] = {};
  for (int first = -taps; first <= taps; first += kSideBySide) {
    for (int lane = 0; lane < kSideBySide; lane += static_cast<int>(hn::Lanes(f))) {
      const VF t = hn::Iota(f, static_cast<float>(first + lane));
      const VF x =
          hn::Min(hn::Max(hn::Add(hn::Set(f, line), hn::Mul(t, hn::Set(f, lines_per_tap))), zero),
                  last_line);
      const VF y = hn::Min(
          hn::Max(hn::Add(hn::Set(f, sample), hn::Mul(t, hn::Set(f, samples_per_tap))), zero),
          last_sample);
      const VI column = hn::Min(hn::ConvertTo(d, x), last_cell_line);
      const VI row = hn::Min(hn::ConvertTo(d, y), last_cell_sample);
      const VF u = hn::Sub(x, hn::ConvertTo(f, column));
      const VF v = hn::Sub(y, hn::ConvertTo(f, row));
      const VI at = hn::Add(hn::Mul(row, stride), column);
      const VF upper =
          Lerp(hn::GatherIndex(f, plane.data, at), hn::GatherIndex(f, plane.data + 1, at), u);
      const VF lower = Lerp(hn::GatherIndex(f, plane.data + plane.stride, at),
                            hn::GatherIndex(f, plane.data + plane.stride + 1, at), u);
      const VF value = hn::IfThenElseZero(hn::Le(t, last_tap), Lerp(upper, lower, v));
      hn::Store(hn::Add(hn::Load(f, sum + lane), value), f, sum + lane);
    }
  }
  float whole = 0.0F;
  for (const float part : sum) whole += part;
  return whole / static_cast<float>(2 * taps + 1);
}

}  // namespace acus::ultrasound::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::ultrasound::kernels {

HWY_EXPORT(MeanAlong);

float MeanAlong(const BlurredPlane& plane, float line, float sample, float lines_per_tap,
                float samples_per_tap, int taps) {
  return HWY_DYNAMIC_DISPATCH(MeanAlong)(plane, line, sample, lines_per_tap, samples_per_tap, taps);
}

}  // namespace acus::ultrasound::kernels
#endif
