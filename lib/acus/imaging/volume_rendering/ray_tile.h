// The rays of one tile of an image through the CT and the surfaces, many at a time.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <span>
#include <vector>

#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/ray_kernel.h"
#include "acus/imaging/volume_rendering/volume_ray.h"

namespace acus::volume_rendering {

/// A piece of an image: at most kernels::RayTile::kRays pixels.
struct TilePlace {
  int left_px = 0;
  int top_px = 0;
  int width_px = 0;
  int height_px = 0;
};

/// What RayCaster gives for each ray, within rounding, in a fraction of its time. Const access from
/// any number of threads.
class TileCaster {
 public:
  /// @pre scene.ct and what goes with it are there, something is visible, and all outlive this.
  TileCaster(const VolumeScene& scene, const RaySettings& settings, const Camera& camera);

  /// False: the voxels cannot be addressed with 32 bits.
  static bool CanCast(const volume::CtVolume& ct) noexcept;

  /// @param fragments_of  By pixel, row by row: surfaces by rising distance, none after an opaque
  ///     one; empty: there are none.
  /// @param empty_mm  Nothing of the CT shows before that.
  /// @param out  By pixel, row by row; those omitted stay as they are.
  /// @param wanted  By pixel: 0 for those to be omitted; empty: all are cast.
  void Cast(const TilePlace& place, std::span<const std::span<const Fragment>> fragments_of,
            float empty_mm, std::span<RayColour> out,
            std::span<const std::uint8_t> wanted = {}) const;

 private:
  void SetTissue();

  VolumeScene scene_;
  RaySettings settings_;
  Camera camera_;
  Eigen::Vector3d eye_mm_;
  Eigen::Affine3f index_from_ct_;
  kernels::RayScene kernel_;
};

}  // namespace acus::volume_rendering
