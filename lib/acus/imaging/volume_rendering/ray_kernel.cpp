#include "acus/imaging/volume_rendering/ray_kernel.h"

// Compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once per instruction set.
// foreach_target.h must come first.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acus/imaging/volume_rendering/ray_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "acus/imaging/volume_rendering/ray_sampling-inl.h"
#include "acus/imaging/volume_rendering/ray_shading-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace acus::volume_rendering::kernels::HWY_NAMESPACE {

/// What a lane has of the sample before.
enum Before : std::int32_t { kNothing = 0, kHu = 1, kHidden = 2 };

/// The rays that run at present, one a lane.
struct Marching {
  alignas(64) float index_step[3][kLanes];
  alignas(64) float blocks_step[3][kLanes];
  alignas(64) float per_blocks_step[3][kLanes];
  alignas(64) std::int32_t sample[kLanes];
  alignas(64) std::int32_t last[kLanes];
  alignas(64) float passing[kLanes];
  alignas(64) float highest_hu[kLanes];
  alignas(64) std::int32_t before[kLanes];
  alignas(64) float hu_before[kLanes];
  alignas(64) float index_before[3][kLanes];
  // The present sample.
  alignas(64) std::int32_t hidden[kLanes];
  alignas(64) float index[3][kLanes];
  alignas(64) std::int32_t block[3][kLanes];
  alignas(64) float in_blocks[3][kLanes];
  alignas(64) std::int32_t ray[kLanes];  ///< -1: idle.
};

/// Directions of all rays, and the samples between which they are within the blocks.
struct Prepared {
  alignas(64) float index_step[3][RayTile::kRays];
  alignas(64) float blocks_step[3][RayTile::kRays];
  alignas(64) std::int32_t first[RayTile::kRays];
  alignas(64) std::int32_t last[RayTile::kRays];
};

HWY_INLINE VF Row(const float* matrix, int row, const VF* v) {
  const F f;
  return hn::Add(hn::Add(hn::Mul(hn::Set(f, matrix[3 * row]), v[0]),
                         hn::Mul(hn::Set(f, matrix[3 * row + 1]), v[1])),
                 hn::Mul(hn::Set(f, matrix[3 * row + 2]), v[2]));
}

void Prepare(const RayScene& scene, RayTile& tile, Prepared& out) {
  const F f;
  const I d;
  const VF most = hn::Set(f, 1e8F);
  for (int r = 0; r < tile.count; r += static_cast<int>(hn::Lanes(f))) {
    VF direction[3];
    for (int a = 0; a < 3; ++a) {
      direction[a] =
          hn::Add(hn::Add(hn::Set(f, scene.forward[a]),
                          hn::Mul(hn::Load(f, tile.column + r), hn::Set(f, scene.right[a]))),
                  hn::Mul(hn::Load(f, tile.row + r), hn::Set(f, scene.down[a])));
    }
    const VF length = hn::Sqrt(Dot(direction, direction));
    for (int a = 0; a < 3; ++a) {
      direction[a] = hn::Div(direction[a], length);
      hn::Store(direction[a], f, tile.direction[a] + r);
    }
    VF enter = hn::Set(f, tile.empty_mm);
    VF leave = hn::Load(f, tile.end_mm + r);
    for (int a = 0; a < 3; ++a) {
      hn::Store(Row(scene.index_from_ct, a, direction), f, out.index_step[a] + r);
      const VF step = Row(scene.blocks_from_ct, a, direction);
      hn::Store(step, f, out.blocks_step[a] + r);
      const float eye = scene.eye_in_blocks[a];
      const auto end = static_cast<float>(scene.blocks.size[a]);
      // Along an axis that the ray does not move, it is within for ever or never.
      const auto stays = hn::Eq(step, hn::Zero(f));
      const VF one = hn::IfThenElse(stays, hn::Set(f, 1.0F), step);
      const VF low = hn::Div(hn::Set(f, -eye), one);
      const VF high = hn::Div(hn::Set(f, end - eye), one);
      const bool within = eye >= 0.0F && eye < end;
      enter = hn::Max(enter,
                      hn::IfThenElse(stays, hn::Set(f, within ? 0.0F : 1e8F), hn::Min(low, high)));
      leave = hn::Min(leave, hn::IfThenElse(stays, most, hn::Max(low, high)));
    }
    const VF per_step = hn::Set(f, 1.0F / scene.step_mm);
    enter = hn::Min(enter, most);
    leave = hn::Min(leave, most);
    const VI first = hn::ConvertTo(d, hn::Mul(enter, per_step));
    // A piece of ray needs the sample behind it; a maximum takes none from there.
    const VF end = hn::Mul(leave, per_step);
    const VI last = hn::ConvertTo(d, scene.is_maximum ? end : hn::Ceil(end));
    const auto misses = hn::RebindMask(d, hn::Not(hn::Lt(enter, leave)));
    hn::Store(first, d, out.first + r);
    hn::Store(hn::IfThenElse(misses, hn::Set(d, -1), last), d, out.last + r);
  }
}

/// The next ray that meets the blocks takes a lane.
void Refill(const Prepared& rays, const RayTile& tile, int& next, int lane, Marching& m) {
  m.ray[lane] = -1;
  while (next < tile.count && rays.first[next] > rays.last[next]) ++next;
  m.sample[lane] = 0;
  m.last[lane] = -1;
  if (next == tile.count) return;
  const int ray = next++;
  m.ray[lane] = ray;
  m.sample[lane] = rays.first[ray];
  m.last[lane] = rays.last[ray];
  m.passing[lane] = 1.0F;
  m.highest_hu[lane] = kOutsideHu;
  m.before[lane] = kNothing;
  for (int a = 0; a < 3; ++a) {
    m.index_step[a][lane] = rays.index_step[a][ray];
    const float step = rays.blocks_step[a][ray];
    m.blocks_step[a][lane] = step;
    m.per_blocks_step[a][lane] = step == 0.0F ? 1e30F : 1.0F / step;
  }
}

/// Where the present samples of `lanes` lie, in blocks. @return the lanes in visible blocks; of the
/// others, the sample is moved on and nothing is before it.
HWY_INLINE std::uint32_t PassEmpty(const RayScene& scene, std::uint32_t lanes, VF at_mm,
                                   Marching& m) {
  const F f;
  const I d;
  VF place[3];
  VI block[3];
  auto within = hn::Eq(hn::Zero(d), hn::Zero(d));
  for (int a = 0; a < 3; ++a) {
    place[a] =
        hn::Add(hn::Set(f, scene.eye_in_blocks[a]), hn::Mul(at_mm, hn::Load(f, m.blocks_step[a])));
    block[a] = hn::ConvertTo(d, place[a]);
    const VI size = hn::Set(d, scene.blocks.size[a]);
    within = hn::And(
        within, hn::And(hn::RebindMask(d, hn::Ge(place[a], hn::Zero(f))), hn::Lt(block[a], size)));
    hn::Store(place[a], f, m.in_blocks[a]);
    hn::Store(block[a], d, m.block[a]);
  }
  const VI row = hn::Set(d, scene.blocks.size[0]);
  const VI slice = hn::Set(d, scene.blocks.size[0] * scene.blocks.size[1]);
  const VI at = hn::IfThenElseZero(
      within, hn::Add(block[0], hn::Add(hn::Mul(block[1], row), hn::Mul(block[2], slice))));
  const VI word =
      hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(scene.blocks.distance), at);
  const VI distance = hn::And(word, hn::Set(d, 255));
  const std::uint32_t visible = MaskOf(hn::And(within, hn::Eq(distance, hn::Zero(d)))) & lanes;
  if (visible == lanes) return visible;
  // Out of the cube of empty blocks around this one.
  VF exit_mm = hn::Set(f, 1e8F);
  for (int a = 0; a < 3; ++a) {
    const VF step = hn::Load(f, m.blocks_step[a]);
    const VI ahead = hn::Add(block[a], distance);
    const VI behind = hn::Sub(hn::Add(block[a], hn::Set(d, 1)), distance);
    const VI wall = hn::IfThenElse(hn::RebindMask(d, hn::Gt(step, hn::Zero(f))), ahead, behind);
    const VF way =
        hn::Mul(hn::Sub(hn::ConvertTo(f, wall), place[a]), hn::Load(f, m.per_blocks_step[a]));
    exit_mm = hn::Min(exit_mm, hn::IfThenElse(hn::Eq(step, hn::Zero(f)), exit_mm, way));
  }
  const VI one = hn::Set(d, 1);
  const VI steps =
      hn::Max(one, hn::ConvertTo(d, hn::Mul(exit_mm, hn::Set(f, 1.0F / scene.step_mm))));
  const auto moves_on = FromBits(d, lanes & ~visible);
  const VI sample = hn::Load(d, m.sample);
  const VI next = hn::Add(sample, hn::IfThenElse(within, steps, one));
  hn::Store(hn::IfThenElse(moves_on, next, sample), d, m.sample);
  hn::Store(hn::IfThenElse(moves_on, hn::Set(d, kNothing), hn::Load(d, m.before)), d, m.before);
  return visible;
}

/// Places at rest of `lanes`, in voxels.
HWY_INLINE void FindRest(const RayScene& scene, RayHost& host, std::uint32_t lanes, VF at_mm,
                         Marching& m) {
  const F f;
  for (int a = 0; a < 3; ++a) {
    const VF straight =
        hn::Add(hn::Set(f, scene.eye_in_index[a]), hn::Mul(at_mm, hn::Load(f, m.index_step[a])));
    hn::Store(
        hn::IfThenElse(hn::RebindMask(f, FromBits(I(), lanes)), straight, hn::Load(f, m.index[a])),
        f, m.index[a]);
  }
  if (!scene.moves) return;
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const int block[3] = {m.block[0][lane], m.block[1][lane], m.block[2][lane]};
    float index[3] = {m.index[0][lane], m.index[1][lane], m.index[2][lane]};
    const float share[3] = {m.in_blocks[0][lane], m.in_blocks[1][lane], m.in_blocks[2][lane]};
    if (!AddOffset(scene.blocks, block, share, index)) {
      host.RestIndex(m.ray[lane], m.sample[lane], index);
    }
    for (int a = 0; a < 3; ++a) m.index[a][lane] = index[a];
  }
}

/// Looks at the present samples of `lanes`. Those that cannot show anything are moved on.
/// @return the lanes of the others.
std::uint32_t Seek(const RayScene& scene, RayHost& host, std::uint32_t lanes, Marching& m) {
  const F f;
  const I d;
  const VF at_mm = hn::Mul(hn::ConvertTo(f, hn::Load(d, m.sample)), hn::Set(f, scene.step_mm));
  const std::uint32_t visible = PassEmpty(scene, lanes, at_mm, m);
  if (visible == 0) return 0;
  FindRest(scene, host, visible, at_mm, m);
  VF index[3];
  for (int a = 0; a < 3; ++a) index[a] = hn::Load(f, m.index[a]);
  const std::uint32_t hidden = Hides(scene.hidden, index) & visible;
  const VI before = hn::Load(d, m.before);
  const std::uint32_t nothing = hidden & ~MaskOf(hn::Eq(before, hn::Set(d, kHu)));
  const std::uint32_t found = visible & ~nothing;
  hn::Store(
      hn::IfThenElse(FromBits(d, found), hn::IfThenElseZero(FromBits(d, hidden), hn::Set(d, 1)),
                     hn::Load(d, m.hidden)),
      d, m.hidden);
  if (nothing == 0) return found;
  const auto is_nothing = FromBits(d, nothing);
  const auto is_nothing_f = hn::RebindMask(f, is_nothing);
  for (int a = 0; a < 3; ++a) {
    hn::Store(hn::IfThenElse(is_nothing_f, index[a], hn::Load(f, m.index_before[a])), f,
              m.index_before[a]);
  }
  hn::Store(hn::IfThenElse(is_nothing, hn::Set(d, kHidden), before), d, m.before);
  const VI sample = hn::Load(d, m.sample);
  hn::Store(hn::IfThenElse(is_nothing, hn::Add(sample, hn::Set(d, 1)), sample), d, m.sample);
  return found;
}

/// What is between the samples before and these; queues what has to be shaded.
void TakeSamples(const RayScene& scene, RayHost& host, RayTile& tile, std::uint32_t lanes,
                 Marching& m, ShadeQueue& queue) {
  const F f;
  const I d;
  VF index[3];
  VF index_before[3];
  for (int a = 0; a < 3; ++a) {
    index[a] = hn::Load(f, m.index[a]);
    index_before[a] = hn::Load(f, m.index_before[a]);
  }
  const VF hu = HuAt(scene.ct, index);
  const VI before = hn::Load(d, m.before);
  VF hu_before = hn::Load(f, m.hu_before);
  const auto was_hidden = hn::Eq(before, hn::Set(d, kHidden));
  if ((MaskOf(was_hidden) & lanes) != 0) {
    hu_before =
        hn::IfThenElse(hn::RebindMask(f, was_hidden), HuAt(scene.ct, index_before), hu_before);
  }
  const std::uint32_t pieces = lanes & ~MaskOf(hn::Eq(before, hn::Set(d, kNothing)));
  if (pieces != 0) {
    VF emission[4];
    Between(scene.emission, scene.ct, pieces, hu_before, hu, index, emission);
    const std::uint32_t seen = MaskOf(hn::RebindMask(d, hn::Gt(emission[3], hn::Zero(f)))) & pieces;
    if (seen != 0) {
      const VI sample = hn::Load(d, m.sample);
      const VF step_mm = hn::Set(f, scene.step_mm);
      const VF at_mm = hn::Mul(hn::ConvertTo(f, sample), step_mm);
      const VF passing = hn::Load(f, m.passing);
      const VF stays = ExpOfMinus(hn::Mul(emission[3], step_mm));
      alignas(64) float weight[kLanes];
      alignas(64) float at[kLanes];
      alignas(64) float extinction[kLanes];
      hn::Store(hn::Mul(passing, hn::Sub(hn::Set(f, 1.0F), stays)), f, weight);
      hn::Store(at_mm, f, at);
      hn::Store(emission[3], f, extinction);
      hn::Store(
          hn::IfThenElse(hn::RebindMask(f, FromBits(d, seen)), hn::Mul(passing, stays), passing), f,
          m.passing);
      alignas(64) float old_passing[kLanes];
      hn::Store(passing, f, old_passing);
      for (std::uint32_t left = seen; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int ray = m.ray[lane];
        if (tile.fragment_mm[ray] > at[lane]) continue;
        float through = old_passing[lane];
        weight[lane] = host.Absorb(ray, extinction[lane], at[lane] - scene.step_mm, at[lane],
                                   through, tile.fragment_mm[ray]);
        m.passing[lane] = through;
      }
      for (int c = 0; c < 3; ++c) emission[c] = hn::Div(emission[c], emission[3]);
      queue.Push(scene, seen, emission, index, at, weight, m.ray);
    }
  }
  const auto taken = FromBits(d, lanes);
  const auto taken_f = hn::RebindMask(f, taken);
  hn::Store(hn::IfThenElse(taken_f, hu, hn::Load(f, m.hu_before)), f, m.hu_before);
  const VI now = hn::Add(hn::Set(d, kHu), hn::Load(d, m.hidden));
  static_assert(kHu + 1 == kHidden);
  hn::Store(hn::IfThenElse(taken, now, before), d, m.before);
  for (int a = 0; a < 3; ++a) {
    hn::Store(hn::IfThenElse(taken_f, index[a], index_before[a]), f, m.index_before[a]);
  }
  const VI sample = hn::Load(d, m.sample);
  hn::Store(hn::IfThenElse(taken, hn::Add(sample, hn::Set(d, 1)), sample), d, m.sample);
}

/// What has been found so far, and what is at these samples.
void TakeMaxima(const RayScene& scene, std::uint32_t lanes, Marching& m) {
  const F f;
  const I d;
  VF index[3];
  for (int a = 0; a < 3; ++a) index[a] = hn::Load(f, m.index[a]);
  const auto taken = FromBits(d, lanes);
  const VF before = hn::Load(f, m.highest_hu);
  const VF highest =
      hn::IfThenElse(hn::RebindMask(f, taken), hn::Max(before, HuAt(scene.ct, index)), before);
  hn::Store(highest, f, m.highest_hu);
  // A ray that cannot become brighter has ended.
  const auto enough = hn::Ge(highest, hn::Set(f, scene.enough_hu));
  hn::Store(hn::IfThenElse(enough, hn::Zero(f), hn::Load(f, m.passing)), f, m.passing);
  const VI sample = hn::Load(d, m.sample);
  hn::Store(hn::IfThenElse(taken, hn::Add(sample, hn::Set(d, 1)), sample), d, m.sample);
}

/// What a ray has found.
HWY_INLINE void Finish(const RayScene& scene, const Marching& m, int lane, RayTile& tile) {
  const int ray = m.ray[lane];
  if (ray < 0) return;
  if (scene.is_maximum) {
    tile.highest_hu[ray] = m.highest_hu[lane];
  } else {
    tile.passing[ray] = m.passing[lane];
  }
}

void CastRays(const RayScene& scene, RayTile& tile, RayHost& host) {
  const F f;
  const I d;
  Prepared rays;
  Prepare(scene, tile, rays);
  for (int r = 0; r < RayTile::kRays; r += static_cast<int>(hn::Lanes(f))) {
    for (float* colour : tile.colour) hn::Store(hn::Zero(f), f, colour + r);
    hn::Store(hn::Set(f, 1.0F), f, tile.passing + r);
    hn::Store(hn::Set(f, kOutsideHu), f, tile.highest_hu + r);
  }
  Marching m{};
  for (int lane = 0; lane < kLanes; ++lane) {
    m.ray[lane] = m.last[lane] = -1;  // Idle.
  }
  ShadeQueue queue;
  int next = 0;
  const int num_lanes = static_cast<int>(hn::Lanes(f));
  const std::uint32_t all = (1U << num_lanes) - 1U;
  std::uint32_t seeking = 0;
  std::uint32_t ready = 0;
  for (;;) {
    // Rays that have come to their ends make room for others.
    const auto past = hn::Gt(hn::Load(d, m.sample), hn::Load(d, m.last));
    const auto dark = hn::RebindMask(d, hn::Le(hn::Load(f, m.passing), hn::Set(f, scene.dark)));
    for (std::uint32_t ended = MaskOf(hn::Or(past, dark)) & ~ready & all; ended != 0;
         ended &= ended - 1) {
      const int lane = __builtin_ctz(ended);
      Finish(scene, m, lane, tile);
      Refill(rays, tile, next, lane, m);
      seeking &= ~(1U << lane);
      if (m.ray[lane] >= 0) seeking |= 1U << lane;
    }
    if ((seeking | ready) == 0) break;
    // Vectors of samples are taken when they are well filled.
    if (seeking == 0 || __builtin_popcount(ready) > num_lanes * 5 / 8) {
      if (scene.is_maximum) {
        TakeMaxima(scene, ready, m);
      } else {
        TakeSamples(scene, host, tile, ready, m, queue);
      }
      if (queue.count >= 2 * num_lanes) queue.Shade(scene, host, tile);
      seeking |= ready;
      ready = 0;
    } else {
      const std::uint32_t found = Seek(scene, host, seeking, m);
      ready |= found;
      seeking &= ~found;
    }
  }
  while (queue.count > 0) queue.Shade(scene, host, tile);
}

}  // namespace acus::volume_rendering::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace acus::volume_rendering::kernels {

HWY_EXPORT(CastRays);

void CastRays(const RayScene& scene, RayTile& tile, RayHost& host) {
  HWY_DYNAMIC_DISPATCH(CastRays)(scene, tile, host);
}

}  // namespace acus::volume_rendering::kernels
#endif
