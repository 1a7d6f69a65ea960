// An image band by band: triangles drawn, and the rays of its tiles cast.
#pragma once

#include <optional>
#include <vector>

#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/ray_tile.h"
#include "acus/imaging/volume_rendering/volume_ray.h"

namespace acus::volume_rendering {

/// The rows of one image. Const access from any number of threads.
class BandRenderer {
 public:
  /// @param camera  Of the rays: with supersampling there are more than pixels.
  /// @param bands  Sorted for it. As all of `scene`, it must outlive this.
  BandRenderer(const VolumeScene& scene, const RaySettings& settings, const Camera& camera,
               const TriangleBands& bands);

  /// Memory of one thread.
  struct Scratch {
    std::vector<RayColour> pixels;  ///< Of the band, row by row: what Render gives.
    TriangleBands::Band band;
    std::vector<Fragment> met;       ///< Of a tile, pixel by pixel.
    std::vector<RayColour> of_tile;  ///< As are the next three.
    std::vector<std::uint8_t> wanted;
    std::vector<std::size_t> first;
    std::vector<std::span<const Fragment>> fragments_of;
  };
  void Render(int band, Scratch& scratch) const;

 private:
  bool CollectFragments(const TilePlace& tile, int top, Scratch& scratch) const;
  float EmptyMm(const TilePlace& tile) const;
  void CastTile(const TilePlace& tile, int top, Scratch& scratch) const;
  void CastByNeed(const TilePlace& tile, float empty_mm, Scratch& scratch) const;

  VolumeScene scene_;
  RaySettings settings_;
  Camera camera_;
  const TriangleBands& bands_;
  RayCaster ray_caster_;
  std::optional<TileCaster> tile_caster_;
};

}  // namespace acus::volume_rendering
