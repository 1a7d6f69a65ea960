#include "acus/imaging/ultrasound/columns/fibre_kernels.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/ultrasound/columns/fibre_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "acus/imaging/slicing/vectors-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::ultrasound::kernels::HWY_NAMESPACE {
using namespace slicing::kernels::HWY_NAMESPACE;

using U = hn::RebindToUnsigned<F>;
using VU = hn::Vec<U>;

HWY_INLINE VF Product(const float* row, const VF* v) {
  const F f;
  return hn::Add(hn::Add(hn::Mul(hn::Set(f, row[0]), v[0]), hn::Mul(hn::Set(f, row[1]), v[1])),
                 hn::Mul(hn::Set(f, row[2]), v[2]));
}

HWY_INLINE VF Dot(const VF* a, const VF* b) {
  return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

/// The end of HashOfPlace, as a number in [0, 1).
HWY_INLINE VF UniformOf(VU h) {
  const F f;
  const U u;
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(u, 0x2C1B3C6DU));
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<13>(h)), hn::Set(u, 0x297A2D39U));
  h = hn::Xor(h, hn::ShiftRight<16>(h));
  return hn::Mul(hn::ConvertTo(f, hn::BitCast(I(), hn::ShiftRight<8>(h))),
                 hn::Set(f, 1.0F / 16777216.0F));
}

/// Noise at a place in cells, and its slope from cell to cell.
HWY_INLINE VF NoiseAt(const VF* cell, std::uint32_t seed, VF* slope) {
  const F f;
  const U u;
  constexpr std::uint32_t kFactor[3] = {0x9E3779B1U, 0x85EBCA77U, 0xC2B2AE3DU};
  VU low[3];
  VU high[3];
  VF share[3];
  VF rise[3];
  for (int a = 0; a < 3; ++a) {
    const VF floor = hn::Floor(cell[a]);
    const VF part = hn::Sub(cell[a], floor);
    share[a] = hn::Mul(hn::Mul(part, part), hn::Sub(hn::Set(f, 3.0F), hn::Add(part, part)));
    rise[a] = hn::Mul(hn::Set(f, 6.0F), hn::Mul(part, hn::Sub(hn::Set(f, 1.0F), part)));
    const VU factor = hn::Set(u, kFactor[a]);
    low[a] = hn::Mul(hn::BitCast(u, hn::ConvertTo(I(), floor)), factor);
    high[a] = hn::Add(low[a], factor);
  }
  VF corner[8];
  for (int n = 0; n < 8; ++n) {
    const VU h = hn::Xor(hn::Xor((n & 1) != 0 ? high[0] : low[0], (n & 2) != 0 ? high[1] : low[1]),
                         hn::Xor((n & 4) != 0 ? high[2] : low[2], hn::Set(u, seed)));
    corner[n] = UniformOf(h);
  }
  VF along_x[4];
  VF step_x[4];
  for (int n = 0; n < 4; ++n) {
    step_x[n] = hn::Sub(corner[2 * n + 1], corner[2 * n]);
    along_x[n] = hn::Add(corner[2 * n], hn::Mul(share[0], step_x[n]));
  }
  const VF near = Mix(along_x[0], along_x[1], share[1]);
  const VF far = Mix(along_x[2], along_x[3], share[1]);
  slope[0] = hn::Mul(rise[0], Mix(Mix(step_x[0], step_x[1], share[1]),
                                  Mix(step_x[2], step_x[3], share[1]), share[2]));
  slope[1] = hn::Mul(
      rise[1], Mix(hn::Sub(along_x[1], along_x[0]), hn::Sub(along_x[3], along_x[2]), share[2]));
  slope[2] = hn::Mul(rise[2], hn::Sub(far, near));
  return Mix(near, far, share[2]);
}

bool CodeRow(const CodedVoxels& voxels, const slicing::kernels::Lines& lines, float s, int lanes,
             float* which) {
  const F f;
  const I d;
  const U u;
  const std::int32_t strides[3] = {1, voxels.row_voxels, voxels.slice_voxels};
  const auto* words = reinterpret_cast<const std::int32_t*>(voxels.words);
  bool any = false;
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    VI voxel = hn::Zero(d);
    auto inside = hn::Ge(hn::Set(f, 1.0F), hn::Zero(f));
    for (int a = 0; a < 3; ++a) {
      const VF at = hn::Add(hn::Add(hn::Load(f, lines.start[a] + l),
                                    hn::Mul(hn::Set(f, s), hn::Load(f, lines.step[a] + l))),
                            hn::Set(f, 0.5F));
      inside =
          hn::And(inside, hn::And(hn::Ge(at, hn::Zero(f)), hn::Lt(at, hn::Set(f, voxels.size[a]))));
      // Lanes outside read the first voxel.
      const VF safe = hn::IfThenElseZero(inside, at);
      voxel = hn::Add(voxel, hn::Mul(hn::ConvertTo(d, safe), hn::Set(d, strides[a])));
    }
    voxel = hn::IfThenElseZero(hn::RebindMask(d, inside), voxel);
    const VU word = hn::BitCast(u, hn::GatherIndex(d, words, hn::ShiftRight<2>(voxel)));
    const VU bits = hn::ShiftLeft<3>(hn::And(hn::BitCast(u, voxel), hn::Set(u, 3U)));
    const VU code = hn::And(hn::Shr(word, bits), hn::Set(u, 255U));
    const VF out = hn::IfThenElseZero(inside, hn::ConvertTo(f, hn::BitCast(d, code)));
    hn::Store(out, f, which + l);
    any = any || !hn::AllTrue(f, hn::Eq(out, hn::Zero(f)));
  }
  return any;
}

void SheetIntensityRow(const SheetRow& row, int lanes, float* intensity) {
  const F f;
  const VF one = hn::Set(f, 1.0F);
  const VF least = hn::Set(f, 1e-9F);
  for (int l = 0; l < lanes; l += static_cast<int>(hn::Lanes(f))) {
    const auto is_this = hn::Eq(hn::Load(f, row.which + l), hn::Set(f, row.code));
    if (hn::AllFalse(f, is_this)) continue;
    VF index[3];
    VF beam[3];
    VF along[3];
    for (int a = 0; a < 3; ++a) {
      const VF step = hn::Load(f, row.lines.step[a] + l);
      index[a] = hn::Add(hn::Load(f, row.lines.start[a] + l), hn::Mul(hn::Set(f, row.s), step));
      beam[a] = hn::Mul(step, hn::Set(f, row.spacing_mm[a]));
      along[a] = hn::Set(f, row.along[a]);
    }
    const VF beam2 = hn::Max(Dot(beam, beam), hn::Set(f, 1e-18F));
    const VF cosine = Dot(beam, along);
    const VF across =
        ExpMinus16(hn::Div(hn::Mul(hn::Set(f, row.fibre_nepers), hn::Mul(cosine, cosine)), beam2));
    VF cell[3];
    for (int a = 0; a < 3; ++a) cell[a] = Product(row.cells + 3 * a, index);
    VF slope[3];
    const VF noise = NoiseAt(cell, row.seed, slope);
    VF normal[3];
    for (int a = 0; a < 3; ++a) normal[a] = Product(row.normals + 3 * a, slope);
    // Sheets lie where the noise passes its middle, across its slope.
    const VF off = hn::Mul(hn::Sub(noise, hn::Set(f, 0.5F)), hn::Set(f, row.per_thickness));
    const VF lengths = hn::Max(hn::Sqrt(hn::Mul(Dot(normal, normal), beam2)), least);
    const VF facing =
        hn::Min(hn::Max(hn::Div(hn::Abs(Dot(beam, normal)), lengths), hn::Set(f, 1e-3F)), one);
    const VF cos2 = hn::Mul(facing, facing);
    const VF tan2 = hn::Div(hn::Sub(one, cos2), cos2);
    const VF diffuse = hn::Set(f, row.diffuse_share);
    const VF lobe = hn::Add(
        hn::Mul(diffuse, facing),
        hn::Mul(hn::Sub(one, diffuse), ExpMinus16(hn::Mul(hn::Set(f, row.per_lobe), tan2))));
    const VF added = hn::Div(hn::Mul(hn::Mul(across, hn::Set(f, row.sheet)), lobe),
                             hn::Add(one, hn::Mul(off, off)));
    const VF factor = hn::Mul(across, hn::Add(hn::Set(f, row.between), added));
    const VF before = hn::LoadU(f, intensity + l);
    hn::StoreU(hn::IfThenElse(is_this, hn::Mul(before, factor), before), f, intensity + l);
  }
}

}  // namespace acus::ultrasound::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::ultrasound::kernels {

HWY_EXPORT(CodeRow);
HWY_EXPORT(SheetIntensityRow);

bool CodeRow(const CodedVoxels& voxels, const slicing::kernels::Lines& lines, float s, int lanes,
             float* which) {
  return HWY_DYNAMIC_DISPATCH(CodeRow)(voxels, lines, s, lanes, which);
}

void SheetIntensityRow(const SheetRow& row, int lanes, float* intensity) {
  HWY_DYNAMIC_DISPATCH(SheetIntensityRow)(row, lanes, intensity);
}

}  // namespace acus::ultrasound::kernels
#endif  // HWY_ONCE
