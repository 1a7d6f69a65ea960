#include "acus/physics/breathing/displacement_kernel.h"

#include <algorithm>
#include <cstring>
#include <iterator>

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/physics/breathing/displacement_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::breathing::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kLanes = 16;
using F = hn::CappedTag<float, kLanes>;
using I = hn::RebindToSigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
// x, y, z and one more of a node; the same of two nodes beside each other (GCC and Clang).
using Node = float __attribute__((vector_size(16)));
using Nodes = float __attribute__((vector_size(32)));
using StoredNodes = std::int16_t __attribute__((vector_size(16)));

/// Where a vector of points lies in the field.
struct Places {
  alignas(64) std::int32_t cell[3][kLanes];
  alignas(64) float share[3][kLanes];
};

HWY_INLINE VF Dot(VF ax, VF ay, VF az, const float* b) {
  const F f;
  return hn::Add(hn::Add(hn::Mul(ax, hn::Set(f, b[0])), hn::Mul(ay, hn::Set(f, b[1]))),
                 hn::Mul(az, hn::Set(f, b[2])));
}

HWY_INLINE void FindPlaces(const FieldNow& field, VF x, VF y, VF z, Places& out) {
  const F f;
  for (int a = 0; a < 3; ++a) {
    const VF index =
        hn::Add(Dot(x, y, z, field.index_from_ct + 3 * a), hn::Set(f, field.index_offset[a]));
    // The maximum with zero comes last: also for a place that is not finite.
    const VF inside = hn::Max(hn::Min(index, hn::Set(f, field.last[a])), hn::Zero(f));
    const VF low = hn::Min(hn::Floor(inside), hn::Set(f, field.last[a] - 1.0F));
    hn::Store(hn::ConvertTo(I(), low), I(), out.cell[a]);
    hn::Store(hn::Sub(inside, low), f, out.share[a]);
  }
}

/// A node and the next one of its row, and two values more.
HWY_INLINE void LoadPair(const std::int16_t* node, Nodes& out) {
  StoredNodes stored;
  std::memcpy(&stored, node, sizeof(stored));
  out = __builtin_convertvector(stored, Nodes);
}

HWY_INLINE Node First(const Nodes& pair) {
  return __builtin_shufflevector(pair, pair, 0, 1, 2, 3);
}
HWY_INLINE Node Second(const Nodes& pair) {
  return __builtin_shufflevector(pair, pair, 3, 4, 5, 6);
}

/// u and its derivatives by j and k, at two nodes between which a point lies.
struct Jet {
  Nodes value{};
  Nodes by_j{};
  Nodes by_k{};
};

template <bool kWithSlopes>
HWY_INLINE void AddComponent(const FieldNow& field, int component, const Places& at, int lane,
                             Jet& out) {
  const std::int16_t* node = field.values[component] + 3 * at.cell[0][lane] +
                             field.row * at.cell[1][lane] + field.slice * at.cell[2][lane];
  const float j = at.share[1][lane];
  const float k = at.share[2][lane];
  const float unit_mm = field.unit_mm[component];
  Nodes corner;
  Nodes corner_k;
  Nodes next;
  Nodes next_k;
  LoadPair(node, corner);
  LoadPair(node + field.slice, corner_k);
  LoadPair(node + field.row, next);
  LoadPair(node + field.row + field.slice, next_k);
  corner_k -= corner;
  next_k -= next;
  const Nodes low = corner + k * corner_k;
  const Nodes by_j = next + k * next_k - low;
  out.value += unit_mm * (low + j * by_j);
  if constexpr (kWithSlopes) {
    out.by_j += unit_mm * by_j;
    out.by_k += unit_mm * (corner_k + j * (next_k - corner_k));
  }
}

/// Between the two nodes.
HWY_INLINE void StoreBetween(const Nodes& pair, float share, float* to) {
  const Node value = First(pair) + share * (Second(pair) - First(pair));
  std::memcpy(to, &value, sizeof(value));
}

/// Points n, n + 1 ... of a list whose end may be near.
HWY_INLINE void LoadPoints(const float* from, int n, int count, VF* to) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  if (n + lanes <= count) {
    hn::LoadInterleaved3(f, from + 3 * n, to[0], to[1], to[2]);
    return;
  }
  alignas(64) float rest[3 * kLanes] = {};
  std::memcpy(rest, from + 3 * n, static_cast<std::size_t>(3 * (count - n)) * sizeof(float));
  hn::LoadInterleaved3(f, rest, to[0], to[1], to[2]);
}
HWY_INLINE void StorePoints(const VF* from, int n, int count, float* to) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  if (n + lanes <= count) {
    hn::StoreInterleaved3(from[0], from[1], from[2], f, to + 3 * n);
    return;
  }
  alignas(64) float rest[3 * kLanes];
  hn::StoreInterleaved3(from[0], from[1], from[2], f, rest);
  std::memcpy(to + 3 * n, rest, static_cast<std::size_t>(3 * (count - n)) * sizeof(float));
}

void Displacements(const FieldNow& field, const float* rest_mm, int count, float* displacement_mm) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int n = 0; n < count; n += lanes) {
    VF place[4];
    LoadPoints(rest_mm, n, count, place);
    Places at;
    FindPlaces(field, place[0], place[1], place[2], at);
    alignas(64) float values[4 * kLanes];
    for (int lane = 0; lane < lanes; ++lane) {
      Jet jet;
      for (int c = 0; c < field.num_components; ++c) AddComponent<false>(field, c, at, lane, jet);
      StoreBetween(jet.value, at.share[0][lane], values + 4 * lane);
    }
    hn::LoadInterleaved4(f, values, place[0], place[1], place[2], place[3]);
    StorePoints(place, n, count, displacement_mm);
  }
}

/// Two unit vectors that form a right-handed system with a unit normal (Duff et al. 2017, Building
/// an orthonormal basis, revisited).
HWY_INLINE void TangentsOf(const VF* normal, VF (*tangents)[3]) {
  const F f;
  const VF x = normal[0];
  const VF y = normal[1];
  const VF z = normal[2];
  const VF sign = hn::CopySign(hn::Set(f, 1.0F), z);
  const VF a = hn::Neg(hn::Div(hn::Set(f, 1.0F), hn::Add(sign, z)));
  const VF b = hn::Mul(hn::Mul(x, y), a);
  tangents[0][0] = hn::Add(hn::Set(f, 1.0F), hn::Mul(sign, hn::Mul(hn::Mul(x, x), a)));
  tangents[0][1] = hn::Mul(sign, b);
  tangents[0][2] = hn::Neg(hn::Mul(sign, x));
  tangents[1][0] = b;
  tangents[1][1] = hn::Add(sign, hn::Mul(hn::Mul(y, y), a));
  tangents[1][2] = hn::Neg(y);
}

/// u and its derivatives along both tangents, a row of `out` for each of their coordinates.
HWY_INLINE void LookUp(const FieldNow& field, const VF* place, const VF* normal, int first,
                       float (*out)[SurfaceBlock::kPoints]) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  Places at;
  FindPlaces(field, place[0], place[1], place[2], at);
  alignas(64) float values[4][4 * kLanes];  // u, and its derivatives by i, j and k.
  for (int lane = 0; lane < lanes; ++lane) {
    Jet jet;
    AddComponent<true>(field, 0, at, lane, jet);
    const float i = at.share[0][lane];
    const Node by_i = Second(jet.value) - First(jet.value);
    StoreBetween(jet.value, i, values[0] + 4 * lane);
    std::memcpy(values[1] + 4 * lane, &by_i, sizeof(by_i));
    StoreBetween(jet.by_j, i, values[2] + 4 * lane);
    StoreBetween(jet.by_k, i, values[3] + 4 * lane);
  }
  VF u[4];
  VF by_index[3][4];
  hn::LoadInterleaved4(f, values[0], u[0], u[1], u[2], u[3]);
  for (int a = 0; a < 3; ++a) {
    VF* by = by_index[a];
    hn::LoadInterleaved4(f, values[a + 1], by[0], by[1], by[2], by[3]);
  }
  for (int r = 0; r < 3; ++r) hn::StoreU(u[r], f, out[r] + first);
  VF tangents[2][3];
  TangentsOf(normal, tangents);
  for (int t = 0; t < 2; ++t) {
    VF along[3];  // The tangent in indices of the field.
    for (int a = 0; a < 3; ++a) {
      along[a] = Dot(tangents[t][0], tangents[t][1], tangents[t][2], field.index_from_ct + 3 * a);
    }
    for (int r = 0; r < 3; ++r) {
      const VF slope =
          hn::Add(hn::Add(hn::Mul(by_index[0][r], along[0]), hn::Mul(by_index[1][r], along[1])),
                  hn::Mul(by_index[2][r], along[2]));
      hn::StoreU(slope, f, out[3 * (t + 1) + r] + first);
    }
  }
}

/// Rows in 16 bits. @returns what a unit is.
HWY_INLINE float Store16(const float (*rows)[SurfaceBlock::kPoints], int count,
                         std::int16_t (*out)[SurfaceBlock::kPoints]) {
  const F f;
  const hn::Rebind<std::int16_t, F> shorts;
  const int lanes = static_cast<int>(hn::Lanes(f));
  VF most = hn::Zero(f);
  for (int r = 0; r < count; ++r) {
    for (int n = 0; n < SurfaceBlock::kPoints; n += lanes) {
      most = hn::Max(most, hn::Abs(hn::LoadU(f, rows[r] + n)));
    }
  }
  const float unit = hn::GetLane(hn::MaxOfLanes(f, most)) / 32767.0F;
  const VF units = hn::Set(f, unit > 0.0F ? 1.0F / unit : 0.0F);
  for (int r = 0; r < count; ++r) {
    for (int n = 0; n < SurfaceBlock::kPoints; n += lanes) {
      const VI value = hn::NearestInt(hn::Mul(hn::LoadU(f, rows[r] + n), units));
      hn::StoreU(hn::DemoteTo(shorts, value), shorts, out[r] + n);
    }
  }
  return unit;
}

void LookUpSurface(const FieldNow& field, const float* rest_mm, const float* rest_normals,
                   int count, SurfaceBlock* blocks) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int begin = 0; begin < count; begin += SurfaceBlock::kPoints) {
    float rows[SurfaceBlock::kRows][SurfaceBlock::kPoints] = {};
    for (int n = begin; n < std::min(count, begin + SurfaceBlock::kPoints); n += lanes) {
      VF place[3];
      VF normal[3];
      LoadPoints(rest_mm, n, count, place);
      LoadPoints(rest_normals, n, count, normal);
      LookUp(field, place, normal, n - begin, rows);
    }
    // What a vector has beyond the last point must not set the unit.
    for (auto& row : rows)
      std::fill(row + std::min(count - begin, SurfaceBlock::kPoints), std::end(row), 0.0F);
    SurfaceBlock& block = blocks[begin / SurfaceBlock::kPoints];
    block.mm_per_unit = Store16(rows, 3, block.values);
    block.slope_per_unit = Store16(rows + 3, 6, block.values + 3);
  }
}

HWY_INLINE void AddScaled(const std::int16_t* values, float unit, VF& sum) {
  const F f;
  const hn::Rebind<std::int16_t, F> shorts;
  const VF value = hn::ConvertTo(f, hn::PromoteTo(I(), hn::LoadU(shorts, values)));
  sum = hn::Add(sum, hn::Mul(value, hn::Set(f, unit)));
}

/// a x b as a unit vector; `flat` where there is none.
HWY_INLINE void UnitCross(const VF* a, const VF* b, const VF* flat, VF* out) {
  const F f;
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3;
    const int t = (r + 2) % 3;
    out[r] = hn::Sub(hn::Mul(a[s], b[t]), hn::Mul(a[t], b[s]));
  }
  const VF square =
      hn::Add(hn::Add(hn::Mul(out[0], out[0]), hn::Mul(out[1], out[1])), hn::Mul(out[2], out[2]));
  const auto is_flat = hn::Not(hn::Gt(square, hn::Set(f, 1e-12F)));
  const VF length = hn::Sqrt(hn::IfThenElse(is_flat, hn::Set(f, 1.0F), square));
  for (int r = 0; r < 3; ++r) out[r] = hn::IfThenElse(is_flat, flat[r], hn::Div(out[r], length));
}

void MoveSurface(const SurfaceNow& surface, const float* rest_mm, const float* rest_normals,
                 int count, float* world_mm, float* normals) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int n = 0; n < count; n += lanes) {
    VF place[3];
    VF normal[3];
    VF tangents[2][3];
    LoadPoints(rest_mm, n, count, place);
    LoadPoints(rest_normals, n, count, normal);
    TangentsOf(normal, tangents);
    const int in_block = n % SurfaceBlock::kPoints;
    for (int c = 0; c < surface.num_components; ++c) {
      const SurfaceBlock& block = surface.blocks[c][n / SurfaceBlock::kPoints];
      const float unit_mm = surface.weight[c] * block.mm_per_unit;
      const float slope_unit = surface.weight[c] * block.slope_per_unit;
      for (int r = 0; r < 3; ++r) {
        AddScaled(block.values[r] + in_block, unit_mm, place[r]);
        AddScaled(block.values[3 + r] + in_block, slope_unit, tangents[0][r]);
        AddScaled(block.values[6 + r] + in_block, slope_unit, tangents[1][r]);
      }
    }
    VF turned[3];
    UnitCross(tangents[0], tangents[1], normal, turned);
    StorePoints(turned, n, count, normals);
    StorePoints(place, n, count, world_mm);
  }
}

}  // namespace acus::breathing::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::breathing::kernels {

HWY_EXPORT(Displacements);
HWY_EXPORT(LookUpSurface);
HWY_EXPORT(MoveSurface);

void Displacements(const FieldNow& field, const float* rest_mm, int count, float* displacement_mm) {
  HWY_DYNAMIC_DISPATCH(Displacements)(field, rest_mm, count, displacement_mm);
}

void LookUpSurface(const FieldNow& field, const float* rest_mm, const float* rest_normals,
                   int count, SurfaceBlock* blocks) {
  HWY_DYNAMIC_DISPATCH(LookUpSurface)(field, rest_mm, rest_normals, count, blocks);
}

void MoveSurface(const SurfaceNow& surface, const float* rest_mm, const float* rest_normals,
                 int count, float* world_mm, float* normals) {
  HWY_DYNAMIC_DISPATCH(MoveSurface)(surface, rest_mm, rest_normals, count, world_mm, normals);
}

}  // namespace acus::breathing::kernels
#endif
