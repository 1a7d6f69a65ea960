// What rays look up: voxels, hidden cells, knots of the warp, and the table of emission. Included
// once for each instruction set: hence no ordinary include guard.
#if defined(ACUS_VOLUME_RENDERING_RAY_SAMPLING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACUS_VOLUME_RENDERING_RAY_SAMPLING_INL_H
#undef ACUS_VOLUME_RENDERING_RAY_SAMPLING_INL_H
#else
#define ACUS_VOLUME_RENDERING_RAY_SAMPLING_INL_H
#endif

#include <cstring>
#include <hwy/highway.h>

#include "acus/imaging/volume_rendering/ray_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace acus::volume_rendering::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kLanes = 16;
using F = hn::CappedTag<float, kLanes>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
/// x, y, z and one more of one place (GCC and Clang).
using VF4 = float __attribute__((vector_size(16)));

constexpr float kOutsideHu = -1024.0F;

template <class Mask>
HWY_INLINE std::uint32_t MaskOf(Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(I(), mask, bytes);
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U;
}

HWY_INLINE hn::Mask<I> FromBits(I d, std::uint32_t bits) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits & 255U),
                                 static_cast<std::uint8_t>(bits >> 8U)};
  return hn::LoadMaskBits(d, bytes);
}

HWY_INLINE VF Dot(const VF* a, const VF* b) {
  return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

HWY_INLINE VF Mix(VF low, VF high, VF share) {
  return hn::Add(low, hn::Mul(share, hn::Sub(high, low)));
}

/// Voxels i and i + 1 lie side by side: one 32-bit load fetches both.
HWY_INLINE VF AlongRow(const std::int16_t* data, VI byte_offset, VF share) {
  const F f;
  const I d;
  const VI pair = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(data), byte_offset);
  const VF low = hn::ConvertTo(f, hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)));
  return Mix(low, hn::ConvertTo(f, hn::ShiftRight<16>(pair)), share);
}

/// Trilinear; air outside.
HWY_INLINE VF HuAt(const VoxelGrid& grid, const VF* index) {
  const F f;
  const I d;
  auto within = hn::Eq(hn::Zero(f), hn::Zero(f));
  VI cell[3];
  VF share[3];
  for (int a = 0; a < 3; ++a) {
    const VF last = hn::Set(f, grid.last[a]);
    within = hn::And(within, hn::And(hn::Ge(index[a], hn::Zero(f)), hn::Le(index[a], last)));
    // Also for a place that is not finite: the maximum with zero comes last.
    const VF inside = hn::Max(hn::Min(index[a], last), hn::Zero(f));
    const VF low = hn::Min(hn::Floor(inside), hn::Set(f, grid.last[a] - 1.0F));
    cell[a] = hn::ConvertTo(d, low);
    share[a] = hn::Sub(inside, low);
  }
  const VI row = hn::Set(d, grid.row_bytes);
  const VI slice = hn::Set(d, grid.slice_bytes);
  VI at =
      hn::Add(hn::ShiftLeft<1>(cell[0]), hn::Add(hn::Mul(cell[1], row), hn::Mul(cell[2], slice)));
  at = hn::IfThenElseZero(hn::RebindMask(d, within), at);
  const VI far = hn::Add(at, slice);
  const VF near_value = Mix(AlongRow(grid.data, at, share[0]),
                            AlongRow(grid.data, hn::Add(at, row), share[0]), share[1]);
  const VF far_value = Mix(AlongRow(grid.data, far, share[0]),
                           AlongRow(grid.data, hn::Add(far, row), share[0]), share[1]);
  return hn::IfThenElse(within, Mix(near_value, far_value, share[2]), hn::Set(f, kOutsideHu));
}

/// See HiddenCells::Hides. @return a bit for each lane.
HWY_INLINE std::uint32_t Hides(const CellBits& cells, const VF* index) {
  if (cells.bits == nullptr) return 0;
  const F f;
  const I d;
  auto within = hn::Eq(hn::Zero(f), hn::Zero(f));
  VI cell[3];
  for (int a = 0; a < 3; ++a) {
    within = hn::And(
        within, hn::And(hn::Ge(index[a], hn::Zero(f)), hn::Lt(index[a], hn::Set(f, cells.end[a]))));
    cell[a] = hn::ShiftRight<1>(hn::ConvertTo(d, index[a]));
  }
  const VI row = hn::Add(hn::Mul(cell[2], hn::Set(d, cells.rows)), cell[1]);
  const auto is_within = hn::RebindMask(d, within);
  const VI bit =
      hn::IfThenElseZero(is_within, hn::Add(hn::Mul(row, hn::Set(d, cells.row_bits)), cell[0]));
  const VI word =
      hn::GatherIndex(d, reinterpret_cast<const std::int32_t*>(cells.bits), hn::ShiftRight<5>(bit));
  const VI one = hn::Set(d, 1);
  const VI mask = hn::Shl(one, hn::And(bit, hn::Set(d, 31)));
  return MaskOf(hn::And(is_within, hn::Ne(hn::And(word, mask), hn::Zero(d))));
}

HWY_INLINE VF4 Load4(const float* at) {
  VF4 out;
  std::memcpy(&out, at, sizeof(out));
  return out;
}

HWY_INLINE VF4 Mix4(VF4 low, VF4 high, float share) {
  return low + share * (high - low);
}

/// Adds what WarpLattice::OffsetAt says. @return false if the block is not smooth.
HWY_INLINE bool AddOffset(const BlockGrid& blocks, const int* block, const float* in_blocks,
                          float* index) {
  const int number = (block[2] * blocks.size[1] + block[1]) * blocks.size[0] + block[0];
  if (blocks.smooth == nullptr || blocks.smooth[number] == 0) return false;
  const std::ptrdiff_t row = 4 * (blocks.size[0] + 1);
  const std::ptrdiff_t slice = row * (blocks.size[1] + 1);
  const float* corner = blocks.knots + slice * block[2] + row * block[1] + 4 * block[0];
  float share[3];
  for (int a = 0; a < 3; ++a) share[a] = in_blocks[a] - static_cast<float>(block[a]);
  const auto along = [&](const float* at)
                         HWY_ATTR { return Mix4(Load4(at), Load4(at + 4), share[0]); };
  const VF4 near = Mix4(along(corner), along(corner + row), share[1]);
  const VF4 far = Mix4(along(corner + slice), along(corner + slice + row), share[1]);
  const VF4 offset = Mix4(near, far, share[2]);
  for (int a = 0; a < 3; ++a) index[a] += offset[a];
  return true;
}

/// The first voxel of the cell around places.
HWY_INLINE VI CellAt(const VoxelGrid& grid, const VF* index, VF* share) {
  const F f;
  const I d;
  VI cell[3];
  for (int a = 0; a < 3; ++a) {
    const VF inside = hn::Max(hn::Min(index[a], hn::Set(f, grid.last[a])), hn::Zero(f));
    const VF low = hn::Min(hn::Floor(inside), hn::Set(f, grid.last[a] - 1.0F));
    cell[a] = hn::ConvertTo(d, low);
    share[a] = hn::Sub(inside, low);
  }
  return hn::Add(cell[0], hn::Add(hn::Mul(cell[1], hn::Set(d, grid.row_bytes / 2)),
                                  hn::Mul(cell[2], hn::Set(d, grid.slice_bytes / 2))));
}

/// From one entry of a table of integrals to another, times their distance; or the entry.
HWY_INLINE VF4 PieceSum(const EmissionTable& table, int from, int to) {
  if (from == to) return Load4(table.value + 4 * static_cast<std::ptrdiff_t>(to));
  return Load4(table.integral + 4 * static_cast<std::ptrdiff_t>(to)) -
         Load4(table.integral + 4 * static_cast<std::ptrdiff_t>(from));
}

/// The classes of the voxels around a place have their shares in it: borders of labels fade.
HWY_INLINE VF4 PieceSumOfClasses(const EmissionTable& table, const VoxelGrid& grid,
                                 std::int32_t voxel, const float* share, int from, int to) {
  VF4 sum{};
  for (int n = 0; n < 8; ++n) {
    const float weight = ((n & 1) != 0 ? share[0] : 1.0F - share[0]) *
                         ((n & 2) != 0 ? share[1] : 1.0F - share[1]) *
                         ((n & 4) != 0 ? share[2] : 1.0F - share[2]);
    const int at = voxel + (n & 1) + ((n & 2) != 0 ? grid.row_bytes / 2 : 0) +
                   ((n & 4) != 0 ? grid.slice_bytes / 2 : 0);
    const int first = table.count * table.classes[at];
    sum += weight * PieceSum(table, first + from, first + to);
  }
  return sum;
}

/// See TransferFunction::Between; only of `lanes`, the others show nothing.
HWY_INLINE void Between(const EmissionTable& table, const VoxelGrid& grid, std::uint32_t lanes,
                        VF from_hu, VF to_hu, const VF* index, VF* emission) {
  const F f;
  const I d;
  const auto entry = [&](VF hu) HWY_ATTR {
    const VF place = hn::Sub(hu, hn::Set(f, table.lowest_hu));
    const VF most = hn::Set(f, static_cast<float>(table.count - 1));
    return hn::ConvertTo(d, hn::Max(hn::Min(place, most), hn::Zero(f)));
  };
  const VI from = entry(from_hu);
  const VI to = entry(to_hu);
  alignas(64) std::int32_t from_at[kLanes];
  alignas(64) std::int32_t to_at[kLanes];
  alignas(64) std::int32_t voxel[kLanes];
  alignas(64) float share[3][kLanes];
  alignas(64) float sums[4 * kLanes] = {};
  hn::Store(from, d, from_at);
  hn::Store(to, d, to_at);
  if (table.classes != nullptr) {
    VF of_cell[3];
    hn::Store(CellAt(grid, index, of_cell), d, voxel);
    for (int a = 0; a < 3; ++a) hn::Store(of_cell[a], f, share[a]);
  }
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const int n = __builtin_ctz(left);
    VF4 sum;
    if (table.classes == nullptr) {
      sum = PieceSum(table, from_at[n], to_at[n]);
    } else {
      const float of_lane[3] = {share[0][n], share[1][n], share[2][n]};
      sum = PieceSumOfClasses(table, grid, voxel[n], of_lane, from_at[n], to_at[n]);
    }
    std::memcpy(sums + 4 * n, &sum, sizeof(sum));
  }
  hn::LoadInterleaved4(f, sums, emission[0], emission[1], emission[2], emission[3]);
  const VI count = hn::Sub(to, from);
  const VF span =
      hn::ConvertTo(f, hn::IfThenElse(hn::Eq(count, hn::Zero(d)), hn::Set(d, 1), count));
  for (int c = 0; c < 4; ++c) emission[c] = hn::Div(emission[c], span);
}

/// exp(-x) for x >= 0, at most 1: a power of two, and a series over half an octave to either side;
/// relative error < 3e-7.
HWY_INLINE VF ExpOfMinus(VF x) {
  const F f;
  const I d;
  const VF octaves = hn::Max(hn::Mul(x, hn::Set(f, -1.44269504F)), hn::Set(f, -126.0F));
  const VF whole = hn::Round(octaves);
  const VF t = hn::Mul(hn::Sub(octaves, whole), hn::Set(f, 0.693147181F));
  VF series = hn::Set(f, 1.0F / 720.0F);
  for (const float factor : {1.0F / 120.0F, 1.0F / 24.0F, 1.0F / 6.0F, 0.5F, 1.0F, 1.0F}) {
    series = hn::Add(hn::Mul(series, t), hn::Set(f, factor));
  }
  const VI power = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(d, whole), hn::Set(d, 127)));
  return hn::Mul(series, hn::BitCast(f, power));
}

}  // namespace acus::volume_rendering::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
