#include "acus/imaging/slicing/kernels.h"

#include <algorithm>

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/slicing/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "acus/imaging/slicing/bend_row.h"
#include "acus/imaging/slicing/vectors-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::slicing::kernels::HWY_NAMESPACE {
/// Index of the lower neighbour and the fraction towards the upper one, along one axis.
struct Cell {
  VI index;
  VF fraction;
};

HWY_INLINE Cell CellAt(VF position, float last) {
  const F f;
  const VF inside = hn::Min(hn::Max(position, hn::Zero(f)), hn::Set(f, last));
  const VF low = hn::Min(hn::Floor(inside), hn::Set(f, last - 1.0F));
  return {hn::ConvertTo(I(), low), hn::Sub(inside, low)};
}

HWY_INLINE VF Lerp(VF a, VF b, VF fraction) {
  return hn::Add(a, hn::Mul(fraction, hn::Sub(b, a)));
}

/// Voxels i and i + 1 lie side by side: one 32-bit load fetches both.
HWY_INLINE VF LerpPair(const std::int16_t* data, VI byte_offset, VF fraction) {
  const F f;
  const I d;
  const VI pair = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(data), byte_offset);
  const VF low = hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)));
  const VF high = hn::ConvertTo(f, hn::ShiftRight<16>(pair));
  return Lerp(low, high, fraction);
}

void SampleRow(const Voxels& voxels, const Lines& lines, float s, int lanes, float* out) {
  const F f;
  const I d;
  const VF sample = hn::Set(f, s);
  const VF outside = hn::Set(f, voxels.outside);
  const VI row = hn::Set(d, voxels.row_bytes);
  const VI slice = hn::Set(d, voxels.slice_bytes);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VF position[3];
    auto within = hn::Eq(sample, sample);
    for (int a = 0; a < 3; ++a) {
      position[a] =
          hn::Add(hn::Load(f, lines.start[a] + l), hn::Mul(sample, hn::Load(f, lines.step[a] + l)));
      within = hn::And(within, hn::And(hn::Ge(position[a], hn::Set(f, -0.5F)),
                                       hn::Le(position[a], hn::Set(f, voxels.edge[a]))));
    }
    if (hn::AllFalse(f, within)) {
      hn::Store(outside, f, out + l);
      continue;
    }
    const Cell i = CellAt(position[0], voxels.last[0]);
    const Cell j = CellAt(position[1], voxels.last[1]);
    const Cell k = CellAt(position[2], voxels.last[2]);
    const VI near =
        hn::Add(hn::ShiftLeft<1>(i.index), hn::Add(hn::Mul(j.index, row), hn::Mul(k.index, slice)));
    const VI far = hn::Add(near, slice);
    const VF near_value = Lerp(LerpPair(voxels.data, near, i.fraction),
                               LerpPair(voxels.data, hn::Add(near, row), i.fraction), j.fraction);
    const VF far_value = Lerp(LerpPair(voxels.data, far, i.fraction),
                              LerpPair(voxels.data, hn::Add(far, row), i.fraction), j.fraction);
    const VF value = Lerp(near_value, far_value, k.fraction);
    hn::Store(hn::IfThenElse(within, value, outside), f, out + l);
  }
}

void SpreadRow(const KnotRow& row, int lanes, float* out) {
  const F f;
  const int step = static_cast<int>(hn::Lanes(f));
  for (int l = 0, c = 0; l < lanes; ++c) {
    const float left = row.offset[c];
    const float change = row.offset[c + 1] - left;
    const int end = c + 1 < row.cells ? row.knot[c + 1] : lanes;
    // What a vector writes beyond the cell is written again by the next one.
    for (; l < end && l + step <= lanes; l += step) {
      const VF weight = hn::LoadU(f, row.weight + l);
      hn::StoreU(hn::Add(hn::Set(f, left), hn::Mul(weight, hn::Set(f, change))), f, out + l);
    }
    for (; l < end; ++l) out[l] = left + row.weight[l] * change;
    l = end;
  }
}

void BendRow(const BentRow& row, int lanes, float* out) {
  const F f;
  const VF sample = hn::Set(f, row.sample);
  const VF down = hn::Set(f, row.down);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF straight =
        hn::Add(hn::Load(f, row.start + l), hn::Mul(sample, hn::Load(f, row.step + l)));
    const VF offset = Lerp(hn::Load(f, row.above + l), hn::Load(f, row.below + l), down);
    hn::Store(hn::Add(straight, offset), f, out + l);
  }
}

void CurveRow(const Curve& curve, const float* hu, int lanes, float* out) {
  const F f;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF x = hn::Load(f, hu + l);
    VF value = hn::Set(f, curve.first_value);
    for (int n = 0; n < curve.num_knots; ++n) {
      const VF beyond = hn::Max(hn::Zero(f), hn::Sub(x, hn::Set(f, curve.hu_knot[n])));
      value = hn::Add(value, hn::Mul(hn::Set(f, curve.slope_change[n]), beyond));
    }
    hn::Store(value, f, out + l);
  }
}

void ReflectRow(const EchoRow& row, const float* z0, const float* z, const float* z1, int lanes,
                float* reflected) {
  const F f;
  const VF share = hn::Set(f, row.share_per_sample);
  const VF threshold = hn::Set(f, row.threshold);
  const VF boosted = hn::Set(f, row.boosted_per_sample);
  const VF metal = hn::Set(f, row.metal_impedance);
  const VF of_metal = hn::Set(f, row.metal_per_sample);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF a = hn::Load(f, z0 + l);
    const VF b = hn::Load(f, z1 + l);
    const VF amplitude = hn::Div(hn::Sub(b, a), hn::Add(b, a));
    const VF r = hn::Mul(amplitude, amplitude);
    const VF strong = hn::IfThenElse(hn::Gt(hn::Max(a, b), metal), of_metal, boosted);
    const VF here = hn::Load(f, z + l);
    const auto passed = hn::Ge(hn::Abs(hn::Sub(here, a)), hn::Abs(hn::Sub(b, here)));
    const VF weak = hn::Mul(hn::Min(r, threshold), share);
    hn::Store(hn::IfThenElse(hn::And(hn::Gt(r, threshold), passed), strong, weak), f,
              reflected + l);
  }
}

void AngleRowWeights(const AngleRow& row, int lanes, float* weight) {
  const F f;
  const VF axial = hn::Set(f, row.per_two_axial_mm);
  const VF lateral = hn::Set(f, row.per_two_lateral_mm);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF gy = hn::Mul(axial, hn::Sub(hn::Load(f, row.below + l), hn::Load(f, row.above + l)));
    const VF gx =
        hn::Mul(lateral, hn::Sub(hn::LoadU(f, row.here + l + 1), hn::LoadU(f, row.here + l - 1)));
    const VF yy = hn::Mul(gy, gy);
    // Without any gradient there is no reflection either: the tiny term only avoids 0 / 0.
    const VF sum = hn::Add(hn::Add(yy, hn::Mul(gx, gx)), hn::Set(f, 1e-12F));
    const VF cosine_squared = hn::Div(yy, sum);
    hn::Store(row.exponent == 1 ? hn::Sqrt(cosine_squared) : cosine_squared, f, weight + l);
  }
}

void PropagateRow(const float* reflected, const float* weight, const float* scattered, int lanes,
                  float* energy, float* echo) {
  const F f;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF arriving = hn::Load(f, energy + l);
    const VF r = hn::Load(f, reflected + l);
    VF back = weight != nullptr ? hn::Mul(r, hn::Load(f, weight + l)) : r;
    if (scattered != nullptr) back = hn::Add(back, hn::Load(f, scattered + l));
    hn::Store(hn::Mul(arriving, back), f, echo + l);
    const VF passed = hn::Sub(hn::Set(f, 1.0F), r);
    hn::Store(hn::Mul(arriving, hn::Mul(passed, passed)), f, energy + l);
  }
}

void AttenuateRow(const float* nepers, int lanes, float* energy) {
  const F f;
  const VF two = hn::Set(f, 2.0F);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF x = hn::Min(two, hn::Load(f, nepers + l));
    const VF left = hn::Div(hn::Sub(two, x), hn::Add(two, x));
    hn::Store(hn::Mul(hn::Load(f, energy + l), left), f, energy + l);
  }
}

void TextureRow(const Tile& tile, const Lines& lines, float s, int lanes, float* scattered) {
  const F f;
  const I d;
  const VF sample = hn::Set(f, s);
  const VI mask = hn::Set(d, (1 << tile.log2_size) - 1);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VI offset = hn::Zero(d);
    for (int a = 2; a >= 0; --a) {
      const VF index =
          hn::Add(hn::Load(f, lines.start[a] + l), hn::Mul(sample, hn::Load(f, lines.step[a] + l)));
      const VF cell = hn::Floor(hn::Mul(index, hn::Set(f, tile.per_index[a])));
      const VI wrapped = hn::And(hn::ConvertTo(d, cell), mask);
      offset = hn::Add(hn::ShiftLeftSame(offset, tile.log2_size), wrapped);
    }
    const VI bytes = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(tile.data), offset);
    const VF amplitude =
        hn::Mul(hn::ConvertTo(f, hn::And(bytes, hn::Set(d, 255))), hn::Set(f, tile.unit));
    hn::Store(hn::Mul(hn::Load(f, scattered + l), hn::Mul(amplitude, amplitude)), f, scattered + l);
  }
}

void BlurAlongRow(const float* const* rows, const float* weight, int half, int lanes, float* out) {
  const F f;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VF sum = hn::Mul(hn::Set(f, weight[0]), hn::Load(f, rows[half] + l));
    for (int t = 1; t <= half; ++t) {
      const VF pair = hn::Add(hn::Load(f, rows[half - t] + l), hn::Load(f, rows[half + t] + l));
      sum = hn::Add(sum, hn::Mul(hn::Set(f, weight[t]), pair));
    }
    hn::Store(sum, f, out + l);
  }
}

void BlurAcrossRow(const float* in, const float* weight, int half, int lanes, float* out) {
  const F f;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VF sum = hn::Mul(hn::Set(f, weight[0]), hn::Load(f, in + l));
    for (int t = 1; t <= half; ++t) {
      const VF pair = hn::Add(hn::LoadU(f, in + l - t), hn::LoadU(f, in + l + t));
      sum = hn::Add(sum, hn::Mul(hn::Set(f, weight[t]), pair));
    }
    hn::Store(sum, f, out + l);
  }
}

void CompressRow(const float* in, float gain, float scale, int lanes, std::uint8_t* out) {
  const F f;
  const VF one = hn::Set(f, 1.0F);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF x = hn::Add(one, hn::Mul(hn::Set(f, gain), hn::Load(f, in + l)));
    StoreGrey(hn::Mul(hn::Set(f, scale), Log2(x)), out + l);
  }
}

void WindowRow(const float* in, float offset, float scale, int lanes, std::uint8_t* out) {
  const F f;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VF scaled = hn::Mul(hn::Set(f, scale), hn::Load(f, in + l));
    StoreGrey(hn::Add(hn::Set(f, offset), scaled), out + l);
  }
}

void InterpolateRow(const std::uint8_t* image, std::int32_t stride, const std::int32_t* offset,
                    const float* across, const float* along, int lanes, std::uint8_t* out) {
  const F f;
  const I d;
  const VI byte = hn::Set(d, 255);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const VI given = hn::Load(d, offset + l);
    const VI safe = hn::Max(given, hn::Zero(d));
    const auto* base = reinterpret_cast<const std::int32_t*>(image);
    const VI upper = hn::GatherOffset(d, base, safe);
    const VI lower = hn::GatherOffset(d, base, hn::Add(safe, hn::Set(d, stride)));
    const VF fraction = hn::Load(f, across + l);
    const auto between = [&](VI pair) {
      const VF left = hn::ConvertTo(f, hn::And(pair, byte));
      const VF right = hn::ConvertTo(f, hn::And(hn::ShiftRight<8>(pair), byte));
      return Lerp(left, right, fraction);
    };
    const VF value = Lerp(between(upper), between(lower), hn::Load(f, along + l));
    const auto outside = hn::RebindMask(f, hn::Lt(given, hn::Zero(d)));
    StoreGrey(hn::IfThenElse(outside, hn::Zero(f), value), out + l);
  }
}

}  // namespace acus::slicing::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::slicing::kernels {

HWY_EXPORT(SampleRow);
HWY_EXPORT(SpreadRow);
HWY_EXPORT(BendRow);
HWY_EXPORT(CurveRow);
HWY_EXPORT(ReflectRow);
HWY_EXPORT(AngleRowWeights);
HWY_EXPORT(PropagateRow);
HWY_EXPORT(AttenuateRow);
HWY_EXPORT(TextureRow);
HWY_EXPORT(BlurAlongRow);
HWY_EXPORT(BlurAcrossRow);
HWY_EXPORT(CompressRow);
HWY_EXPORT(WindowRow);
HWY_EXPORT(InterpolateRow);

void SampleRow(const Voxels& voxels, const Lines& lines, float s, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(voxels, lines, s, lanes, out);
}
void SpreadRow(const KnotRow& row, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(SpreadRow)(row, lanes, out);
}
void BendRow(const BentRow& row, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(BendRow)(row, lanes, out);
}
void CurveRow(const Curve& curve, const float* hu, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(CurveRow)(curve, hu, lanes, out);
}
void ReflectRow(const EchoRow& row, const float* z0, const float* z, const float* z1, int lanes,
                float* reflected) {
  HWY_DYNAMIC_DISPATCH(ReflectRow)(row, z0, z, z1, lanes, reflected);
}
void AngleRowWeights(const AngleRow& row, int lanes, float* weight) {
  HWY_DYNAMIC_DISPATCH(AngleRowWeights)(row, lanes, weight);
}
void PropagateRow(const float* reflected, const float* weight, const float* scattered, int lanes,
                  float* energy, float* echo) {
  HWY_DYNAMIC_DISPATCH(PropagateRow)(reflected, weight, scattered, lanes, energy, echo);
}
void AttenuateRow(const float* nepers, int lanes, float* energy) {
  HWY_DYNAMIC_DISPATCH(AttenuateRow)(nepers, lanes, energy);
}
void TextureRow(const Tile& tile, const Lines& lines, float s, int lanes, float* scattered) {
  HWY_DYNAMIC_DISPATCH(TextureRow)(tile, lines, s, lanes, scattered);
}
void BlurAlongRow(const float* const* rows, const float* weight, int half, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(BlurAlongRow)(rows, weight, half, lanes, out);
}
void BlurAcrossRow(const float* in, const float* weight, int half, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(BlurAcrossRow)(in, weight, half, lanes, out);
}
void CompressRow(const float* in, float gain, float scale, int lanes, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(CompressRow)(in, gain, scale, lanes, out);
}
void WindowRow(const float* in, float offset, float scale, int lanes, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(WindowRow)(in, offset, scale, lanes, out);
}
void InterpolateRow(const std::uint8_t* image, std::int32_t stride, const std::int32_t* offset,
                    const float* across, const float* along, int lanes, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(InterpolateRow)(image, stride, offset, across, along, lanes, out);
}

}  // namespace acus::slicing::kernels
#endif  // HWY_ONCE
