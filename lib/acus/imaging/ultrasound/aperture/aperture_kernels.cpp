#include "acus/imaging/ultrasound/aperture/aperture_kernels.h"

#include <cmath>

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/ultrasound/aperture/aperture_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "acus/imaging/slicing/vectors-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::ultrasound::kernels::HWY_NAMESPACE {
using namespace slicing::kernels::HWY_NAMESPACE;

HWY_INLINE int LanesPerStep() {
  return static_cast<int>(hn::Lanes(F()));
}

/// The three codes of packed voxels.
struct Codes {
  VF zeta;
  VF nepers;
  VF scatter;
};

HWY_INLINE Codes Unpack(VI packed) {
  const F f;
  const I d;
  const VI ten = hn::Set(d, 1023);
  return {hn::ConvertTo(f, hn::And(hn::ShiftRight<20>(packed), hn::Set(d, 4095))),
          hn::ConvertTo(f, hn::And(hn::ShiftRight<10>(packed), ten)),
          hn::ConvertTo(f, hn::And(packed, ten))};
}

/// The voxels `at` and `at + 1` of each lane.
struct VoxelPair {
  VI first;
  VI second;
};

/// Both voxels of a pair come by one load: they lie beside each other.
HWY_INLINE VoxelPair GatherPair(const std::uint32_t* data, VI at) {
  const I d;
#if HWY_TARGET == HWY_SCALAR
  const auto* voxels = reinterpret_cast<const std::int32_t*>(data);
  return {hn::GatherIndex(d, voxels, at), hn::GatherIndex(d, voxels + 1, at)};
#else
  const hn::Repartition<std::int64_t, I> wide;
  const hn::Half<I> half;
  const auto* base = reinterpret_cast<const std::int64_t*>(data);
  const VI bytes = hn::ShiftLeft<2>(at);
  const VI low =
      hn::BitCast(d, hn::GatherOffset(wide, base, hn::PromoteTo(wide, hn::LowerHalf(half, bytes))));
  const VI high =
      hn::BitCast(d, hn::GatherOffset(wide, base, hn::PromoteTo(wide, hn::UpperHalf(half, bytes))));
  return {hn::ConcatEven(d, high, low), hn::ConcatOdd(d, high, low)};
#endif
}

HWY_INLINE Codes MixCodes(const Codes& a, const Codes& b, VF share) {
  return {Mix(a.zeta, b.zeta, share), Mix(a.nepers, b.nepers, share),
          Mix(a.scatter, b.scatter, share)};
}

void SampleAcousticRow(const AcousticVoxels& voxels, const Lines& lines, float s, int lanes,
                       const AcousticRow& out) {
  const F f;
  const I d;
  const VF sample = hn::Set(f, s);
  const VF one = hn::Set(f, 1.0F);
  const std::int32_t strides[3] = {1, voxels.row_voxels, voxels.slice_voxels};
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    VF seen = one;
    VI low = hn::Zero(d);
    VF share[3] = {seen, seen, seen};
    for (int a = 0; a < 3; ++a) {
      const VF at =
          hn::Add(hn::Load(f, lines.start[a] + l), hn::Mul(sample, hn::Load(f, lines.step[a] + l)));
      const auto in_grid =
          hn::And(hn::Ge(at, hn::Set(f, -0.5F)), hn::Le(at, hn::Set(f, voxels.edge[a])));
      seen = hn::IfThenElseZero(in_grid, seen);
      const VF last = hn::Set(f, voxels.last[a]);
      const VF inside =
          hn::Min(hn::Max(hn::Sub(at, hn::Set(f, voxels.first[a])), hn::Zero(f)), last);
      // The pair of voxels lies within the box, also at its far side.
      const VF floor = hn::Min(hn::Floor(inside), hn::Sub(last, one));
      share[a] = hn::Sub(inside, floor);
      low = hn::Add(low, hn::Mul(hn::ConvertTo(d, floor), hn::Set(d, strides[a])));
    }
    const auto pair = [&](std::int32_t offset) {
      const VoxelPair found = GatherPair(voxels.data + offset, low);
      return MixCodes(Unpack(found.first), Unpack(found.second), share[0]);
    };
    const Codes near = MixCodes(pair(0), pair(strides[1]), share[1]);
    const Codes far = MixCodes(pair(strides[2]), pair(strides[1] + strides[2]), share[1]);
    const Codes found = MixCodes(near, far, share[2]);
    hn::Store(
        hn::Add(hn::Set(f, voxels.zeta_first), hn::Mul(found.zeta, hn::Set(f, voxels.zeta_unit))),
        f, out.zeta + l);
    hn::Store(hn::Mul(found.nepers, hn::Set(f, voxels.nepers_unit)), f, out.nepers + l);
    hn::Store(hn::Mul(found.scatter, hn::Set(f, voxels.scatter_unit)), f, out.scatter + l);
    hn::Store(seen, f, out.seen + l);
  }
}

void AddLossRow(const LossRow& row, int lanes) {
  const F f;
  const VF zero = hn::Zero(f);
  const VF one = hn::Set(f, 1.0F);
  // Between the densest soft tissue and bone; between water and gas.
  constexpr float kSoftest = 0.36F;
  constexpr float kBone = 1.0F;
  const VF half_step = hn::Set(f, 0.5F * row.step_mm);
  const VF weight = hn::Set(f, row.weight);
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    const VF zeta = hn::Load(f, row.zeta + l);
    const VF seen = hn::Load(f, row.seen + l);
    const VF bone =
        hn::Mul(hn::Sub(zeta, hn::Set(f, kSoftest)), hn::Set(f, 1.0F / (kBone - kSoftest)));
    const VF gas = hn::Mul(zeta, hn::Set(f, -2.0F));
    const VF strong = hn::Min(hn::Max(hn::Max(bone, gas), zero), one);
    VF nepers =
        hn::Add(hn::Load(f, row.nepers + l), hn::Mul(strong, hn::Set(f, row.strong_nepers)));
    // Nothing comes back from where there is no patient.
    nepers = hn::IfThenElse(hn::Gt(seen, zero), nepers, hn::Set(f, 1e3F));
    VF left = hn::Mul(weight, ExpMinus16(hn::Mul(nepers, half_step)));
    const VF scatter = hn::Mul(hn::Load(f, row.scatter + l), seen);
    VF scatter2 = hn::Mul(weight, hn::Mul(scatter, scatter));
    if (row.add) {
      left = hn::Add(left, hn::Load(f, row.left + l));
      scatter2 = hn::Add(scatter2, hn::Load(f, row.scatter2 + l));
    }
    hn::Store(left, f, row.left + l);
    hn::Store(scatter2, f, row.scatter2 + l);
  }
}

/// A ray that is fainter has ended: the product of many losses would be a denormal number.
constexpr float kFaintestRay = 1e-15F;

void MarchRayRow(const RayRow& row, int lanes) {
  const F f;
  const VF faintest = hn::Set(f, kFaintestRay);
  const int whole = static_cast<int>(std::floor(row.shift));
  const VF share = hn::Set(f, row.shift - static_cast<float>(whole));
  const int step = LanesPerStep();
  for (int r = -row.margin; r < lanes + row.margin; r += step) {
    // Lines beyond those of the image are copies of the outermost.
    const int at = r + whole;
    const int safe = at < -row.margin                     ? -row.margin
                     : at > lanes + row.margin - step - 1 ? lanes + row.margin - step - 1
                                                          : at;
    const VF left = Mix(hn::LoadU(f, row.left + safe), hn::LoadU(f, row.left + safe + 1), share);
    const VF ray = hn::Mul(hn::LoadU(f, row.ray + r), left);
    hn::StoreU(hn::IfThenElseZero(hn::Ge(ray, faintest), ray), f, row.ray + r);
  }
  if (row.weight == 0.0F) return;
  const VF weight = hn::Set(f, row.weight);
  for (int l = 0; l < lanes; l += step) {
    // Ray l - shift: between l - whole - 1 and l - whole.
    const float* ray = row.ray + l - whole;
    const VF arriving = hn::Mul(weight, Mix(hn::LoadU(f, ray), hn::LoadU(f, ray - 1), share));
    hn::Store(hn::Add(arriving, hn::Load(f, row.arriving + l)), f, row.arriving + l);
  }
}

void LerpRow(const float* a, const float* b, float share, int lanes, float* out) {
  const F f;
  const VF s = hn::Set(f, share);
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    hn::Store(Mix(hn::Load(f, a + l), hn::Load(f, b + l), s), f, out + l);
  }
}

void AddScaledRow(const float* in, float scale, int lanes, float* out) {
  const F f;
  const VF s = hn::Set(f, scale);
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    hn::Store(hn::Add(hn::Load(f, out + l), hn::Mul(s, hn::LoadU(f, in + l))), f, out + l);
  }
}

void SquareRow(const float* amplitude, const float* square, int lanes, float* out) {
  const F f;
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    const VF a = hn::Load(f, amplitude + l);
    hn::Store(hn::Mul(hn::Mul(a, a), hn::Load(f, square + l)), f, out + l);
  }
}

void AddRootRow(const float* more, float share, int lanes, float* intensity) {
  const F f;
  const VF s = hn::Set(f, share);
  for (int l = 0; l < lanes; l += LanesPerStep()) {
    const VF sum = hn::Add(hn::Load(f, intensity + l), hn::Mul(s, hn::LoadU(f, more + l)));
    hn::Store(hn::Sqrt(sum), f, intensity + l);
  }
}

}  // namespace acus::ultrasound::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::ultrasound::kernels {

HWY_EXPORT(SampleAcousticRow);
HWY_EXPORT(AddLossRow);
HWY_EXPORT(MarchRayRow);
HWY_EXPORT(LerpRow);
HWY_EXPORT(AddScaledRow);
HWY_EXPORT(SquareRow);
HWY_EXPORT(AddRootRow);

void SampleAcousticRow(const AcousticVoxels& voxels, const Lines& lines, float s, int lanes,
                       const AcousticRow& out) {
  HWY_DYNAMIC_DISPATCH(SampleAcousticRow)(voxels, lines, s, lanes, out);
}
void AddLossRow(const LossRow& row, int lanes) {
  HWY_DYNAMIC_DISPATCH(AddLossRow)(row, lanes);
}
void MarchRayRow(const RayRow& row, int lanes) {
  HWY_DYNAMIC_DISPATCH(MarchRayRow)(row, lanes);
}
void LerpRow(const float* a, const float* b, float share, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(LerpRow)(a, b, share, lanes, out);
}
void AddScaledRow(const float* in, float scale, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(AddScaledRow)(in, scale, lanes, out);
}
void SquareRow(const float* amplitude, const float* square, int lanes, float* out) {
  HWY_DYNAMIC_DISPATCH(SquareRow)(amplitude, square, lanes, out);
}
void AddRootRow(const float* more, float share, int lanes, float* intensity) {
  HWY_DYNAMIC_DISPATCH(AddRootRow)(more, share, lanes, intensity);
}

}  // namespace acus::ultrasound::kernels
#endif  // HWY_ONCE
