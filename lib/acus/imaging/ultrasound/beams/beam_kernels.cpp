#include "acus/imaging/ultrasound/beams/beam_kernels.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/ultrasound/beams/beam_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "acus/imaging/slicing/vectors-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::ultrasound::kernels::HWY_NAMESPACE {
using namespace slicing::kernels::HWY_NAMESPACE;

HWY_INLINE int Step() {
  return static_cast<int>(hn::Lanes(F()));
}

/// a b + c, rounded twice: an instruction set that can round once would give other bits.
HWY_INLINE VF MulThenAdd(VF a, VF b, VF c) {
  return hn::Add(hn::Mul(a, b), c);
}

HWY_INLINE VF Place(const Lines& lines, int axis, VF sample, int l) {
  const F f;
  return hn::Add(hn::Load(f, lines.start[axis] + l),
                 hn::Mul(sample, hn::Load(f, lines.step[axis] + l)));
}

void LabelRow(const LabelVoxels& voxels, const Lines& lines, float s, int lanes,
              std::int32_t* label) {
  const F f;
  const I d;
  const VF sample = hn::Set(f, s);
  const VF half = hn::Set(f, 0.5F);
  const std::int32_t bytes[3] = {1, voxels.row_bytes, voxels.slice_bytes};
  for (int l = 0; l < lanes; l += Step()) {
    auto within = hn::Eq(sample, sample);
    VI offset = hn::Zero(d);
    for (int a = 0; a < 3; ++a) {
      const VF at = Place(lines, a, sample, l);
      const auto inside =
          hn::And(hn::Ge(at, hn::Set(f, -0.5F)), hn::Lt(at, hn::Set(f, voxels.edge[a])));
      within = hn::And(within, inside);
      // Truncation rounds down: inside, the sum is not negative.
      const VI index = hn::ConvertTo(d, hn::IfThenElseZero(inside, hn::Add(at, half)));
      offset = a == 0 ? index : hn::Add(offset, hn::Mul(index, hn::Set(d, bytes[a])));
    }
    // Four bytes are loaded: at the very end, four bytes that are still there.
    const VI safe = hn::Min(offset, hn::Set(d, voxels.last_word));
    const VI shift = hn::ShiftLeft<3>(hn::Sub(offset, safe));
    const VI word = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(voxels.data), safe);
    const VI found = hn::And(hn::Shr(word, shift), hn::Set(d, 255));
    hn::Store(hn::IfThenElse(hn::RebindMask(d, within), found, hn::Set(d, kNotScannedLabel)), d,
              label + l);
  }
}

void TissueOfLabelRow(const LabelTables& tables, const std::int32_t* label, int lanes,
                      const TissueRow& out) {
  const F f;
  const I d;
  for (int l = 0; l < lanes; l += Step()) {
    const VI index = hn::Load(d, label + l);
    hn::Store(hn::GatherIndex(f, tables.log_impedance, index), f, out.log_impedance + l);
    hn::Store(hn::GatherIndex(f, tables.decay, index), f, out.decay + l);
    hn::Store(hn::GatherIndex(f, tables.scatter, index), f, out.scatter + l);
  }
}

/// exp(-x) for x in [0, 2], by (exp(-x / 4))^4 and a series of the fourth order: within 1e-5.
HWY_INLINE VF ExpMinus(VF x) {
  const F f;
  const VF y = hn::Mul(hn::Min(x, hn::Set(f, 2.0F)), hn::Set(f, -0.25F));
  VF e = hn::Add(hn::Set(f, 1.0F / 6.0F), hn::Mul(y, hn::Set(f, 1.0F / 24.0F)));
  e = hn::Add(hn::Set(f, 0.5F), hn::Mul(y, e));
  e = hn::Add(hn::Set(f, 1.0F), hn::Mul(y, e));
  e = hn::Add(hn::Set(f, 1.0F), hn::Mul(y, e));
  e = hn::Mul(e, e);
  return hn::Mul(e, e);
}

void TissueOfHuRow(const TissueCurves& curves, const float* hu, int lanes, const TissueRow& out) {
  const F f;
  for (int l = 0; l < lanes; l += Step()) {
    const VF x = hn::Load(f, hu + l);
    VF a = hn::Set(f, curves.first_value[0]);
    VF b = hn::Set(f, curves.first_value[1]);
    VF c = hn::Set(f, curves.first_value[2]);
    for (int n = 0; n < curves.num_knots; ++n) {
      const VF beyond = hn::Max(hn::Zero(f), hn::Sub(x, hn::Set(f, curves.hu_knot[n])));
      a = hn::Add(a, hn::Mul(hn::Set(f, curves.slope_change[0][n]), beyond));
      b = hn::Add(b, hn::Mul(hn::Set(f, curves.slope_change[1][n]), beyond));
      c = hn::Add(c, hn::Mul(hn::Set(f, curves.slope_change[2][n]), beyond));
    }
    hn::Store(a, f, out.log_impedance + l);
    hn::Store(ExpMinus(b), f, out.decay + l);
    hn::Store(c, f, out.scatter + l);
  }
}

bool FindInterfacesRow(const InterfaceRow& row, int lanes) {
  const F f;
  const VF zero = hn::Zero(f);
  const VF middle = hn::Set(f, row.k - 0.5F);
  bool any = false;
  for (int l = 0; l < lanes; l += Step()) {
    const VF z = hn::Load(f, row.log_impedance + l);
    const VF previous = hn::Load(f, row.previous + l);
    const VF start = hn::Load(f, row.start + l);
    const VF moment = hn::Load(f, row.moment + l);
    const VF step = hn::Sub(z, previous);
    const VF run = hn::Sub(previous, start);
    const auto steep = hn::Gt(hn::Abs(step), hn::Set(f, row.min_step));
    const auto goes_on = hn::And(steep, hn::Ge(hn::Mul(step, run), zero));
    const auto ended = hn::AndNot(goes_on, hn::Gt(hn::Abs(run), hn::Set(f, row.min_run)));
    hn::Store(z, f, row.previous + l);
    // A run that turns round begins at the row before; without a run, the start follows the tissue.
    const VF restart = hn::IfThenElse(steep, previous, z);
    hn::Store(hn::IfThenElse(goes_on, start, restart), f, row.start + l);
    const VF added = hn::IfThenElseZero(steep, hn::Mul(step, middle));
    hn::Store(hn::Add(hn::IfThenElseZero(goes_on, moment), added), f, row.moment + l);
    hn::Store(hn::IfThenElseZero(ended, run), f, row.run + l);
    if (!hn::AllFalse(f, ended)) {
      any = true;
      hn::Store(hn::Div(moment, hn::IfThenElse(ended, run, hn::Set(f, 1.0F))), f, row.place + l);
    }
  }
  return any;
}

/// A random 32-bit number for the state of a lattice point.
HWY_INLINE VI Mixed(VI state) {
  const I d;
  const hn::RebindToUnsigned<I> u;
  auto h = hn::BitCast(u, state);
  h = hn::Xor(h, hn::ShiftRight<15>(h));
  h = hn::Mul(h, hn::Set(u, 0x2C1B3C6DU));
  h = hn::Xor(h, hn::ShiftRight<13>(h));
  h = hn::Mul(h, hn::Set(u, 0x297A2D39U));
  h = hn::Xor(h, hn::ShiftRight<15>(h));
  return hn::BitCast(d, h);
}

struct Noise {
  VF re;
  VF im;
};

/// Adds weight times the number of a lattice point. Both parts are u |u| of a uniform u in
/// (-2^15, 2^15): nearly as peaked as a normal number, which a mean of few uniform ones is not.
HWY_INLINE void AddPoint(VI state, VF weight, Noise& sum) {
  const F f;
  const VI h = Mixed(state);
  const VF re = hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(h)));
  const VF im = hn::ConvertTo(f, hn::ShiftRight<16>(h));
  sum.re = hn::Add(sum.re, hn::Mul(weight, hn::Mul(re, hn::Abs(re))));
  sum.im = hn::Add(sum.im, hn::Mul(weight, hn::Mul(im, hn::Abs(im))));
}

/// Noise of variance 1 (|.|^2) at a position in the lattice.
HWY_INLINE Noise NoiseAt(VF x, VF y, VF z) {
  const F f;
  const I d;
  const VF fx = hn::Floor(x);
  const VF fy = hn::Floor(y);
  const VF fz = hn::Floor(z);
  x = hn::Sub(x, fx);
  y = hn::Sub(y, fy);
  z = hn::Sub(z, fz);
  constexpr std::int32_t kX = static_cast<std::int32_t>(0x9E3779B1U);
  constexpr std::int32_t kY = static_cast<std::int32_t>(0x85EBCA77U);
  constexpr std::int32_t kZ = static_cast<std::int32_t>(0xC2B2AE3DU);
  constexpr std::int32_t kAll = static_cast<std::int32_t>(0x9E3779B1U + 0x85EBCA77U + 0xC2B2AE3DU);
  const VI low = hn::Add(hn::Add(hn::Mul(hn::ConvertTo(d, fx), hn::Set(d, kX)),
                                 hn::Mul(hn::ConvertTo(d, fy), hn::Set(d, kY))),
                         hn::Mul(hn::ConvertTo(d, fz), hn::Set(d, kZ)));
  const VI high = hn::Add(low, hn::Set(d, kAll));
  // The tetrahedron: from the low corner along the largest fraction first, along the smallest last.
  const VF most = hn::Max(x, hn::Max(y, z));
  const VF least = hn::Min(x, hn::Min(y, z));
  const VF middle = hn::Sub(hn::Sub(hn::Add(hn::Add(x, y), z), most), least);
  const auto largest = [&](VF of) { return hn::RebindMask(d, hn::Eq(of, most)); };
  const auto smallest = [&](VF of) { return hn::RebindMask(d, hn::Eq(of, least)); };
  const VI first = hn::IfThenElse(largest(x), hn::Set(d, kX),
                                  hn::IfThenElse(largest(y), hn::Set(d, kY), hn::Set(d, kZ)));
  const VI last = hn::IfThenElse(smallest(z), hn::Set(d, kZ),
                                 hn::IfThenElse(smallest(y), hn::Set(d, kY), hn::Set(d, kX)));
  const VF w0 = hn::Sub(hn::Set(f, 1.0F), most);
  const VF w1 = hn::Sub(most, middle);
  const VF w2 = hn::Sub(middle, least);
  const VF squares = hn::Add(hn::Add(hn::Mul(w0, w0), hn::Mul(w1, w1)),
                             hn::Add(hn::Mul(w2, w2), hn::Mul(least, least)));
  Noise sum{hn::Zero(f), hn::Zero(f)};
  AddPoint(low, w0, sum);
  AddPoint(hn::Add(low, first), w1, sum);
  AddPoint(hn::Sub(high, last), w2, sum);
  AddPoint(high, least, sum);
  // 1 / sqrt(squares) on [1/4, 1] by a polynomial (within 0.7 %), and the variance of the numbers.
  constexpr float kUnit = 1.46884e-9F;  // sqrt(5 / 2) / 2^30, less what the polynomial adds
  VF norm = hn::Set(f, -2.438732F * kUnit);
  norm = hn::Add(hn::Mul(norm, squares), hn::Set(f, 6.230593F * kUnit));
  norm = hn::Add(hn::Mul(norm, squares), hn::Set(f, -5.911374F * kUnit));
  norm = hn::Add(hn::Mul(norm, squares), hn::Set(f, 3.112478F * kUnit));
  return {hn::Mul(sum.re, norm), hn::Mul(sum.im, norm)};
}

/// a * b, complex.
HWY_INLINE Noise Times(const Noise& a, const Noise& b) {
  return {hn::Sub(hn::Mul(a.re, b.re), hn::Mul(a.im, b.im)),
          hn::Add(hn::Mul(a.re, b.im), hn::Mul(a.im, b.re))};
}

/// Fainter amplitudes are none: shadows cost nothing, and stay out of the denormal numbers.
constexpr float kFaintestSpeckle = 1e-12F;

template <bool kAdd, bool kTurn>
HWY_INLINE void SpeckleEcho(const SpeckleRow& row, float s, int lanes) {
  const F f;
  const VF sample = hn::Set(f, s);
  const VF gain = hn::Set(f, row.gain);
  for (int l = 0; l < lanes; l += Step()) {
    const VF energy = hn::Load(f, row.energy + l);
    const VF arriving = hn::Mul(hn::Mul(energy, gain), hn::Load(f, row.scatter + l));
    const auto heard = hn::Ge(arriving, hn::Set(f, kFaintestSpeckle));
    hn::Store(hn::Mul(energy, hn::Load(f, row.decay + l)), f, row.energy_after + l);
    if (hn::AllFalse(f, heard)) {
      if constexpr (!kAdd) {
        hn::Store(hn::Zero(f), f, row.re + l);
        hn::Store(hn::Zero(f), f, row.im + l);
      }
      continue;
    }
    const VF amplitude = hn::IfThenElseZero(heard, arriving);
    Noise noise = NoiseAt(Place(row.lattice, 0, sample, l), Place(row.lattice, 1, sample, l),
                          Place(row.lattice, 2, sample, l));
    if constexpr (kTurn) {
      const Noise of_lane{hn::Load(f, row.turn_of_lane[0] + l),
                          hn::Load(f, row.turn_of_lane[1] + l)};
      const Noise of_row{hn::Set(f, row.turn_of_row[0]), hn::Set(f, row.turn_of_row[1])};
      noise = Times(noise, Times(of_lane, of_row));
    }
    VF re = hn::Mul(amplitude, noise.re);
    VF im = hn::Mul(amplitude, noise.im);
    if constexpr (kAdd) {
      re = hn::Add(re, hn::Load(f, row.re + l));
      im = hn::Add(im, hn::Load(f, row.im + l));
    }
    hn::Store(re, f, row.re + l);
    hn::Store(im, f, row.im + l);
  }
}

void SpeckleEchoRow(const SpeckleRow& row, float s, int lanes, bool add) {
  if (row.turn_of_lane[0] != nullptr) {
    add ? SpeckleEcho<true, true>(row, s, lanes) : SpeckleEcho<false, true>(row, s, lanes);
  } else {
    add ? SpeckleEcho<true, false>(row, s, lanes) : SpeckleEcho<false, false>(row, s, lanes);
  }
}

void DecayRow(const float* energy, const float* decay, int lanes, float* after) {
  const F f;
  for (int l = 0; l < lanes; l += Step()) {
    hn::Store(hn::Mul(hn::Load(f, energy + l), hn::Load(f, decay + l)), f, after + l);
  }
}

void FillUnlabelledRow(const std::int32_t* label, const TissueRow& other, int lanes,
                       const TissueRow& out) {
  const F f;
  const I d;
  for (int l = 0; l < lanes; l += Step()) {
    const auto none = hn::RebindMask(f, hn::Eq(hn::Load(d, label + l), hn::Zero(d)));
    const auto fill = [&](float* to, const float* from) {
      hn::Store(hn::IfThenElse(none, hn::Load(f, from + l), hn::Load(f, to + l)), f, to + l);
    };
    fill(out.log_impedance, other.log_impedance);
    fill(out.decay, other.decay);
    fill(out.scatter, other.scatter);
  }
}

void FilterAlongRow(const float* const* rows, const float* weight, int half, int lanes,
                    float* out) {
  const F f;
  for (int l = 0; l < lanes; l += Step()) {
    VF sum = hn::Mul(hn::Set(f, weight[0]), hn::Load(f, rows[half] + l));
    for (int t = 1; t <= half; ++t) {
      const VF pair = hn::Add(hn::Load(f, rows[half - t] + l), hn::Load(f, rows[half + t] + l));
      sum = MulThenAdd(hn::Set(f, weight[t]), pair, sum);
    }
    hn::Store(sum, f, out + l);
  }
}

void FilterAcrossRow(const float* re, const float* im, const float* weight, int half, int lanes,
                     float* intensity) {
  const F f;
  for (int l = 0; l < lanes; l += Step()) {
    const VF centre = hn::Set(f, weight[0]);
    VF a = hn::Mul(centre, hn::Load(f, re + l));
    VF b = hn::Mul(centre, hn::Load(f, im + l));
    for (int t = 1; t <= half; ++t) {
      const VF w = hn::Set(f, weight[t]);
      a = MulThenAdd(w, hn::Add(hn::LoadU(f, re + l - t), hn::LoadU(f, re + l + t)), a);
      b = MulThenAdd(w, hn::Add(hn::LoadU(f, im + l - t), hn::LoadU(f, im + l + t)), b);
    }
    hn::Store(MulThenAdd(a, a, hn::Mul(b, b)), f, intensity + l);
  }
}

void GreyRow(const float* intensity, float offset, float scale, int lanes, std::uint8_t* grey) {
  const F f;
  const VF tiny = hn::Set(f, 1e-30F);
  for (int l = 0; l < lanes; l += Step()) {
    const VF x = hn::Max(hn::Load(f, intensity + l), tiny);
    StoreGrey(hn::Add(hn::Set(f, offset), hn::Mul(hn::Set(f, scale), Log2(x))), grey + l);
  }
}

HWY_INLINE VF Lerp(VF a, VF b, VF fraction) {
  return hn::Add(a, hn::Mul(fraction, hn::Sub(b, a)));
}

/// Between the two low bytes of each word.
HWY_INLINE VF LerpBytes(VI pair, VF fraction) {
  const F f;
  const VI byte = hn::Set(I(), 255);
  const VF left = hn::ConvertTo(f, hn::And(pair, byte));
  const VF right = hn::ConvertTo(f, hn::And(hn::ShiftRight<8>(pair), byte));
  return Lerp(left, right, fraction);
}

void ResampleColumnsRow(const ColumnsRow& row, int lanes, std::uint8_t* out) {
  const F f;
  const I d;
  const VF along = hn::Set(f, row.along);
  for (int l = 0; l < lanes; l += Step()) {
    const VI at = hn::LoadU(d, row.column + l);
    const VF across = hn::Load(f, row.across + l);
    const VI upper = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(row.upper), at);
    const VI lower = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(row.lower), at);
    StoreGrey(Lerp(LerpBytes(upper, across), LerpBytes(lower, across), along), out + l);
  }
}

void InterpolatePackedRow(const std::uint8_t* image, std::int32_t stride,
                          const std::int32_t* offset, const std::uint16_t* fractions, int lanes,
                          std::uint8_t* out) {
  const F f;
  const I d;
  const hn::Rebind<std::uint16_t, I> d16;
  const auto* base = reinterpret_cast<const std::int32_t*>(image);
  const VF unit = hn::Set(f, 1.0F / 256.0F);
  for (int l = 0; l < lanes; l += Step()) {
    const VI at = hn::LoadU(d, offset + l);
    const VI both = hn::PromoteTo(d, hn::LoadU(d16, fractions + l));
    const VF across = hn::Mul(unit, hn::ConvertTo(f, hn::And(both, hn::Set(d, 255))));
    const VF along = hn::Mul(unit, hn::ConvertTo(f, hn::ShiftRight<8>(both)));
    const VI upper = hn::GatherOffset(d, base, at);
    const VI lower = hn::GatherOffset(d, base, hn::Add(at, hn::Set(d, stride)));
    StoreGrey(Lerp(LerpBytes(upper, across), LerpBytes(lower, across), along), out + l);
  }
}

}  // namespace acus::ultrasound::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::ultrasound::kernels {

HWY_EXPORT(LabelRow);
HWY_EXPORT(TissueOfLabelRow);
HWY_EXPORT(TissueOfHuRow);
HWY_EXPORT(FindInterfacesRow);
HWY_EXPORT(SpeckleEchoRow);
HWY_EXPORT(DecayRow);
HWY_EXPORT(FillUnlabelledRow);
HWY_EXPORT(FilterAlongRow);
HWY_EXPORT(FilterAcrossRow);
HWY_EXPORT(GreyRow);
HWY_EXPORT(ResampleColumnsRow);
HWY_EXPORT(InterpolatePackedRow);

void LabelRow(const LabelVoxels& voxels, const Lines& lines, float s, int lanes,
              std::int32_t* label) {
  HWY_DYNAMIC_DISPATCH(LabelRow)(voxels, lines, s, lanes, label);
}
void TissueOfLabelRow(const LabelTables& tables, const std::int32_t* label, int lanes,
                      const TissueRow& out) {
  HWY_DYNAMIC_DISPATCH(TissueOfLabelRow)(tables, label, lanes, out);
}
void TissueOfHuRow(const TissueCurves& curves, const float* hu, int lanes, const TissueRow& out) {
  HWY_DYNAMIC_DISPATCH(TissueOfHuRow)(curves, hu, lanes, out);
}
bool FindInterfacesRow(const InterfaceRow& row, int lanes) {
  return HWY_DYNAMIC_DISPATCH(FindInterfacesRow)(row, lanes);
}
void SpeckleEchoRow(const SpeckleRow& row, float s, int lanes, bool add) {
  HWY_DYNAMIC_DISPATCH(SpeckleEchoRow)(row, s, lanes, add);
}
void DecayRow(const float* energy, const float* decay, int lanes, float* after) {
  HWY_DYNAMIC_DISPATCH(DecayRow)(energy, decay, lanes, after);
}
void FillUnlabelledRow(const std::int32_t* label, const TissueRow& other, int lanes,
                       const TissueRow& out) {
  HWY_DYNAMIC_DISPATCH(FillUnlabelledRow)(label, other, lanes, out);
}
void FilterAlongRow(const float* const* rows, const float* weight, int half, int lanes,
                    float* out) {
  HWY_DYNAMIC_DISPATCH(FilterAlongRow)(rows, weight, half, lanes, out);
}
void FilterAcrossRow(const float* re, const float* im, const float* weight, int half, int lanes,
                     float* intensity) {
  HWY_DYNAMIC_DISPATCH(FilterAcrossRow)(re, im, weight, half, lanes, intensity);
}
void GreyRow(const float* intensity, float offset, float scale, int lanes, std::uint8_t* grey) {
  HWY_DYNAMIC_DISPATCH(GreyRow)(intensity, offset, scale, lanes, grey);
}
void ResampleColumnsRow(const ColumnsRow& row, int lanes, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ResampleColumnsRow)(row, lanes, out);
}
void InterpolatePackedRow(const std::uint8_t* image, std::int32_t stride,
                          const std::int32_t* offset, const std::uint16_t* fractions, int lanes,
                          std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(InterpolatePackedRow)(image, stride, offset, fractions, lanes, out);
}

}  // namespace acus::ultrasound::kernels
#endif  // HWY_ONCE
