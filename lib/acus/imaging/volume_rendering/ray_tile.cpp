#include "acus/imaging/volume_rendering/ray_tile.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "acus/imaging/volume_rendering/surface_mix.h"

namespace acus::volume_rendering {
namespace {

using kernels::RayTile;

template <class From>
void CopyTo(const From& from, float* to) {
  for (int n = 0; n < from.size(); ++n) to[n] = from(n);
}

void CopyRows(const Eigen::Matrix3f& from, float (&to)[9]) {
  for (int n = 0; n < 9; ++n) to[n] = from(n / 3, n % 3);
}

kernels::VoxelGrid GridOf(const volume::CtVolume& ct) {
  kernels::VoxelGrid out;
  out.data = ct.voxels.data();
  CopyTo((ct.geometry.size - 1).cast<float>().eval(), out.last);
  out.row_bytes = 2 * ct.geometry.size[0];
  out.slice_bytes = out.row_bytes * ct.geometry.size[1];
  return out;
}

/// Rays of a lane's width lie in squares of four pixels each way: they stay together.
struct Pixel {
  int column;
  int row;
};
Pixel PixelOf(int number, int tile_width) {
  constexpr int kSide = 4;
  const int squares = (tile_width + kSide - 1) / kSide;
  const int square = number / (kSide * kSide);
  const int within = number % (kSide * kSide);
  return {square % squares * kSide + within % kSide, square / squares * kSide + within / kSide};
}

/// What few samples of a tile need.
class TileHost final : public kernels::RayHost {
 public:
  TileHost(const VolumeScene& scene, const RaySettings& settings, const Eigen::Vector3d& eye_mm,
           const Eigen::Affine3f& index_from_ct, const RayTile& tile)
      : scene_(scene),
        settings_(settings),
        eye_mm_(eye_mm),
        index_from_ct_(index_from_ct),
        tile_(tile) {}

  void RestIndex(int ray, int sample, float index[3]) override {
    if (warps_.empty()) warps_.resize(RayTile::kRays);
    Warp& warp = warps_[static_cast<std::size_t>(ray)];
    if (!warp.ray) warp.ray.emplace(*scene_.motion, settings_.warp);
    if (warp.sample != sample - 1) warp.ray->Jump();
    warp.sample = sample;
    const Eigen::Vector3d direction = DirectionOf(ray).cast<double>();
    const Eigen::Vector3d rest_mm = warp.ray->RestOf(
        eye_mm_ + sample * settings_.step_mm * direction, settings_.step_mm * direction);
    Eigen::Map<Eigen::Vector3f>{index} = index_from_ct_ * rest_mm.cast<float>();
  }

  float Absorb(int ray, float extinction_per_mm, float from_mm, float to_mm, float& passing,
               float& fragment_mm) override {
    SurfaceMix& mix = mixes[static_cast<std::size_t>(ray)];
    const float weight = mix.Absorb(extinction_per_mm, from_mm, to_mm, passing);
    fragment_mm = mix.next_mm();
    return weight;
  }

  float LitAt(int ray, float at_mm) override {
    return scene_.shadows->LitAt(eye_mm_.cast<float>() + at_mm * DirectionOf(ray));
  }

  std::vector<SurfaceMix> mixes;  ///< By ray; empty: there are no surfaces.

 private:
  struct Warp {
    std::optional<WarpedRay> ray;
    int sample = std::numeric_limits<int>::min();  ///< The one before.
  };

  Eigen::Vector3f DirectionOf(int ray) const {
    return {tile_.direction[0][ray], tile_.direction[1][ray], tile_.direction[2][ray]};
  }

  const VolumeScene& scene_;
  const RaySettings& settings_;
  const Eigen::Vector3d& eye_mm_;
  const Eigen::Affine3f& index_from_ct_;
  const RayTile& tile_;
  std::vector<Warp> warps_;  ///< By ray; empty: none was needed so far.
};

}  // namespace

bool TileCaster::CanCast(const volume::CtVolume& ct) noexcept {
  return 2 * ct.geometry.num_voxels() < std::size_t{1} << 31U;
}

TileCaster::TileCaster(const VolumeScene& scene, const RaySettings& settings, const Camera& camera)
    : scene_(scene), settings_(settings), camera_(camera), eye_mm_(camera.EyeInCtMm()) {
  const Eigen::Affine3d index_from_ct = scene.ct->geometry.index_from_ct();
  index_from_ct_ = index_from_ct.cast<float>();
  kernels::RayScene& k = kernel_;
  k.ct = GridOf(*scene.ct);
  k.is_maximum = settings.projection == Projection::kMaximum;
  k.enough_hu = static_cast<float>(settings.window.high_hu);
  if (!k.is_maximum) SetTissue();
  if (scene.hidden != nullptr) k.hidden = scene.hidden->bits();
  k.blocks.distance = scene.blocks->distances();
  for (int a = 0; a < 3; ++a) k.blocks.size[a] = scene.blocks->size()[a];
  k.moves = scene.motion != nullptr && scene.motion->moves();
  if (k.moves && scene.lattice != nullptr) {
    k.blocks.smooth = scene.lattice->smooth();
    k.blocks.knots = scene.lattice->knots();
  }
  CopyTo(scene.light.to_lamp, k.lamp.to_lamp);
  k.lamp.ambient = scene.light.ambient;
  k.lamp.diffuse = scene.light.diffuse;
  k.lamp.fill = scene.light.fill;
  k.lamp.gloss = scene.light.gloss;
  const Eigen::Matrix3d ct_from_camera = camera.camera_from_ct.linear().transpose();
  CopyTo(camera.DirectionInCt({0.0, 0.0}).cast<float>().eval(), k.forward);
  CopyTo((ct_from_camera.col(0) / camera.focal_px[0]).cast<float>().eval(), k.right);
  CopyTo((ct_from_camera.col(1) / camera.focal_px[1]).cast<float>().eval(), k.down);
  CopyRows(index_from_ct_.linear(), k.index_from_ct);
  CopyRows(scene.blocks->blocks_from_ct().linear(), k.blocks_from_ct);
  CopyTo((index_from_ct * eye_mm_).cast<float>().eval(), k.eye_in_index);
  CopyTo((scene.blocks->blocks_from_ct() * eye_mm_.cast<float>()).eval(), k.eye_in_blocks);
  CopyRows(scene.ct->geometry.direction.cast<float>(), k.ct_from_slope);
  k.surface_hu_per_mm = kSurfaceHuPerMm;
  k.step_mm = static_cast<float>(settings.step_mm);
  k.dark = kDark;
  k.has_shadows = scene.shadows != nullptr;
}

/// What tissue emits, and what light falls on.
void TileCaster::SetTissue() {
  kernel_.slopes = scene_.slopes->units();
  kernel_.slope_unit = SlopeVolume::kUnit;
  kernel_.emission = scene_.transfer->table();
  if (scene_.classes != nullptr) kernel_.emission.classes = scene_.classes->data();
}

void TileCaster::Cast(const TilePlace& place,
                      std::span<const std::span<const Fragment>> fragments_of, float empty_mm,
                      std::span<RayColour> out, std::span<const std::uint8_t> wanted) const {
  RayTile tile;
  TileHost host(scene_, settings_, eye_mm_, index_from_ct_, tile);
  std::array<int, RayTile::kRays> pixel_of;
  if (!fragments_of.empty()) host.mixes.resize(RayTile::kRays);
  tile.empty_mm = empty_mm;
  const int all = (place.width_px + 3) / 4 * ((place.height_px + 3) / 4) * 16;
  for (int n = 0; n < all; ++n) {
    const Pixel at = PixelOf(n, place.width_px);
    if (at.column >= place.width_px || at.row >= place.height_px) continue;
    const int pixel = at.row * place.width_px + at.column;
    if (!wanted.empty() && wanted[static_cast<std::size_t>(pixel)] == 0) continue;
    const int ray = tile.count++;
    pixel_of[static_cast<std::size_t>(ray)] = pixel;
    tile.column[ray] = static_cast<float>(place.left_px + at.column);
    tile.row[ray] = static_cast<float>(place.top_px + at.row);
    tile.end_mm[ray] = RayTile::kNone;
    tile.fragment_mm[ray] = RayTile::kNone;
    if (fragments_of.empty()) continue;
    const std::span<const Fragment> fragments = fragments_of[static_cast<std::size_t>(pixel)];
    if (fragments.empty()) continue;
    SurfaceMix& mix = host.mixes[static_cast<std::size_t>(ray)];
    mix = SurfaceMix(fragments, static_cast<float>(settings_.tool_shine));
    tile.fragment_mm[ray] = mix.next_mm();
    if (fragments.back().opacity >= 1.0F) tile.end_mm[ray] = fragments.back().distance_mm;
  }
  // Lanes are filled up with rays that end at once.
  for (int ray = tile.count; ray % 16 != 0; ++ray) {
    tile.column[ray] = tile.row[ray] = 0.0F;
    tile.end_mm[ray] = 0.0F;
  }
  kernels::CastRays(kernel_, tile, host);
  for (int ray = 0; ray < tile.count; ++ray) {
    const auto number = static_cast<std::size_t>(ray);
    RayColour& colour = out[static_cast<std::size_t>(pixel_of[number])];
    colour.colour = {tile.colour[0][ray], tile.colour[1][ray], tile.colour[2][ray]};
    float passing = tile.passing[ray];
    SurfaceMix none;
    SurfaceMix& mix = fragments_of.empty() ? none : host.mixes[number];
    if (kernel_.is_maximum) {
      colour.colour += mix.Cover(OpacityIn(settings_.window, tile.highest_hu[ray]), passing);
    }
    mix.Pass(std::numeric_limits<float>::max(), passing);
    colour.opacity = 1.0F - passing;
    mix.Finish(colour.colour, colour.opacity);
  }
}

}  // namespace acus::volume_rendering
