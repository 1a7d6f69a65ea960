#include "acus/imaging/volume_rendering/band_renderer.h"

#include <algorithm>
#include <array>

#include "acus/imaging/volume_rendering/pixel_filling.h"

namespace acus::volume_rendering {
namespace {

/// Rays of a tile look for the first tissue together.
constexpr int kTilePx = 16;
static_assert(kTilePx * TriangleBands::kRows <= kernels::RayTile::kRays);

}  // namespace

BandRenderer::BandRenderer(const VolumeScene& scene, const RaySettings& settings,
                           const Camera& camera, const TriangleBands& bands)
    : scene_(scene),
      settings_(settings),
      camera_(camera),
      bands_(bands),
      ray_caster_(scene, settings, camera.EyeInCtMm()) {
  const bool shows_volume = scene.ct != nullptr && !scene.blocks->nothing_visible();
  // Tiles have neither cuts nor tissue under tools.
  const bool is_plain = scene.pressed == nullptr && scene.cuts.empty();
  if (shows_volume && is_plain && TileCaster::CanCast(*scene.ct)) {
    tile_caster_.emplace(scene, settings, camera);
  }
}

/// @return false if no surface is in the tile.
bool BandRenderer::CollectFragments(const TilePlace& tile, int top, Scratch& scratch) const {
  scratch.met.clear();
  scratch.first.clear();
  scratch.fragments_of.clear();
  for (int row = tile.top_px - top; row < tile.top_px - top + tile.height_px; ++row) {
    for (int column = tile.left_px; column < tile.left_px + tile.width_px; ++column) {
      scratch.first.push_back(scratch.met.size());
      TriangleBands::Append(scratch.band, static_cast<std::size_t>(row * camera_.width_px + column),
                            scratch.met);
    }
  }
  if (scratch.met.empty()) return false;
  scratch.first.push_back(scratch.met.size());
  for (std::size_t n = 0; n + 1 < scratch.first.size(); ++n) {
    scratch.fragments_of.emplace_back(scratch.met.data() + scratch.first[n],
                                      scratch.first[n + 1] - scratch.first[n]);
  }
  return true;
}

/// How far all rays of a tile are empty.
float BandRenderer::EmptyMm(const TilePlace& tile) const {
  const double right = tile.left_px + tile.width_px - 1;
  const double bottom = tile.top_px + tile.height_px - 1;
  const auto ray = [&](double column, double row) {
    return Eigen::Vector3d(camera_.DirectionInCt({column, row}).normalized());
  };
  const std::array rim{ray(tile.left_px, tile.top_px), ray(right, tile.top_px),
                       ray(tile.left_px, bottom), ray(right, bottom)};
  return ray_caster_.EmptyUntilMm(ray(0.5 * (tile.left_px + right), 0.5 * (tile.top_px + bottom)),
                                  rim);
}

void BandRenderer::CastTile(const TilePlace& tile, int top, Scratch& scratch) const {
  const bool has_surfaces = CollectFragments(tile, top, scratch);
  const float empty_mm = EmptyMm(tile);
  scratch.of_tile.assign(static_cast<std::size_t>(tile.width_px * tile.height_px), {});
  const bool shows_volume = empty_mm < RayCaster::kFarMm;
  if (shows_volume && tile_caster_) {
    CastByNeed(tile, empty_mm, scratch);
    return;
  }
  if (!has_surfaces && !shows_volume) return;
  std::size_t pixel = 0;
  for (int row = tile.top_px; row < tile.top_px + tile.height_px; ++row) {
    for (int column = tile.left_px; column < tile.left_px + tile.width_px; ++column, ++pixel) {
      const Eigen::Vector3d direction = camera_.DirectionInCt({column, row}).normalized();
      scratch.of_tile[pixel] = ray_caster_.Cast(
          direction, has_surfaces ? scratch.fragments_of[pixel] : std::span<const Fragment>{},
          empty_mm);
    }
  }
}

/// From coarse to fine: pixels whose neighbours are alike need no ray.
void BandRenderer::CastByNeed(const TilePlace& tile, float empty_mm, Scratch& scratch) const {
  const auto tolerance = static_cast<float>(settings_.pixel_tolerance);
  scratch.wanted.clear();
  if (tolerance > 0.0F) FirstPixels(tile, scratch.wanted);
  tile_caster_->Cast(tile, scratch.fragments_of, empty_mm, scratch.of_tile, scratch.wanted);
  if (!(tolerance > 0.0F)) return;
  for (int stride = kFirstStride; stride > 1; stride /= 2) {
    FillBetween(tile, stride, tolerance, scratch.fragments_of, scratch.of_tile, scratch.wanted);
    tile_caster_->Cast(tile, scratch.fragments_of, empty_mm, scratch.of_tile, scratch.wanted);
  }
}

void BandRenderer::Render(int band, Scratch& scratch) const {
  bands_.Draw(band, scene_.light, scene_.shadows, scratch.band);
  TilePlace tile;
  const int top = band * TriangleBands::kRows;
  tile.top_px = top;
  tile.height_px = std::min(TriangleBands::kRows, camera_.height_px - top);
  scratch.pixels.resize(static_cast<std::size_t>(TriangleBands::kRows) *
                        static_cast<std::size_t>(camera_.width_px));
  for (tile.left_px = 0; tile.left_px < camera_.width_px; tile.left_px += kTilePx) {
    tile.width_px = std::min(kTilePx, camera_.width_px - tile.left_px);
    CastTile(tile, top, scratch);
    for (int row = 0; row < tile.height_px; ++row) {
      std::copy_n(scratch.of_tile.begin() + row * tile.width_px, tile.width_px,
                  scratch.pixels.begin() + static_cast<std::ptrdiff_t>(row) * camera_.width_px +
                      tile.left_px);
    }
  }
}

}  // namespace acus::volume_rendering
