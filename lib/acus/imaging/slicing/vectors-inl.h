// Vectors of kBlock lanes at most, and what several files of kernels do with them. Included once
// for each instruction set: hence no ordinary include guard.
#if defined(ACUS_ULTRASOUND_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACUS_ULTRASOUND_VECTORS_INL_H
#undef ACUS_ULTRASOUND_VECTORS_INL_H
#else
#define ACUS_ULTRASOUND_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include "acus/imaging/slicing/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace acus::slicing::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most kBlock lanes, so that a block is a whole number of vectors on every machine.
using F = hn::CappedTag<float, kBlock>;
using I = hn::RebindToSigned<F>;
using U8 = hn::Rebind<std::uint8_t, F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;

/// log2(x) for x > 0, by exponent and the series of 2 atanh((m - 1) / (m + 1)): error < 1e-6.
HWY_INLINE VF Log2(VF x) {
  const F f;
  const I d;
  // Takes the mantissa into [sqrt(1/2), sqrt(2)), where the series is short.
  const VI shifted = hn::Sub(hn::BitCast(d, x), hn::Set(d, 0x3F3504F3));
  const VI exponent = hn::ShiftRight<23>(shifted);
  const VI mantissa = hn::Add(hn::And(shifted, hn::Set(d, 0x007FFFFF)), hn::Set(d, 0x3F3504F3));
  const VF m = hn::BitCast(f, mantissa);
  const VF one = hn::Set(f, 1.0F);
  const VF t = hn::Div(hn::Sub(m, one), hn::Add(m, one));
  const VF tt = hn::Mul(t, t);
  constexpr float kTwoOverLn2 = 2.885390082F;
  VF series = hn::Set(f, kTwoOverLn2 / 7.0F);
  series = hn::Add(hn::Mul(series, tt), hn::Set(f, kTwoOverLn2 / 5.0F));
  series = hn::Add(hn::Mul(series, tt), hn::Set(f, kTwoOverLn2 / 3.0F));
  series = hn::Add(hn::Mul(series, tt), hn::Set(f, kTwoOverLn2));
  return hn::Add(hn::ConvertTo(f, exponent), hn::Mul(series, t));
}

/// Rounds half up and cuts off to 0 ... 255.
HWY_INLINE void StoreGrey(VF value, std::uint8_t* out) {
  const F f;
  const VF cut = hn::Min(hn::Max(value, hn::Zero(f)), hn::Set(f, 255.0F));
  const VI grey = hn::ConvertTo(I(), hn::Add(cut, hn::Set(f, 0.5F)));
  hn::StoreU(hn::DemoteTo(U8(), grey), U8(), out);
}

/// From one value to another.
HWY_INLINE VF Mix(VF a, VF b, VF share) {
  return hn::Add(a, hn::Mul(share, hn::Sub(b, a)));
}

/// exp(-x) for x in [0, 16], by (exp(-x / 16))^16 and a series of the fourth order: within 2e-6.
HWY_INLINE VF ExpMinus16(VF x) {
  const F f;
  const VF y = hn::Mul(hn::Min(x, hn::Set(f, 16.0F)), hn::Set(f, -0.0625F));
  VF e = hn::Add(hn::Set(f, 1.0F / 6.0F), hn::Mul(y, hn::Set(f, 1.0F / 24.0F)));
  e = hn::Add(hn::Set(f, 0.5F), hn::Mul(y, e));
  e = hn::Add(hn::Set(f, 1.0F), hn::Mul(y, e));
  e = hn::Add(hn::Set(f, 1.0F), hn::Mul(y, e));
  for (int n = 0; n < 4; ++n) e = hn::Mul(e, e);
  return e;
}

}  // namespace acus::slicing::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
