// The patient's acoustic properties on the CT grid, without the stairs of voxel labels.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "acus/imaging/ultrasound/aperture/aperture_kernels.h"
#include "acus/imaging/ultrasound/beams/beam_materials.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Impedance, loss and scatterers of each voxel, smoothed by a binomial window of five voxels (one
/// voxel of standard deviation) along each axis. A boundary between labels becomes a smooth slope,
/// whose middle, normal and whole step do not depend on where the voxels lie. With `texture`, the
/// scatterers follow the CT within each tissue (ct_texture.h).
///
/// Four bytes per voxel, of the box that holds tissue only.
class AcousticVolume {
 public:
  /// Reads labels and CT once, on `num_threads` threads; nothing of them is kept.
  /// @param per_mm  Materials for one millimetre from sample to sample.
  /// @param organs  If given, with labels: the structure of organs (organ_structure.h), of this
  ///     seed.
  AcousticVolume(const BeamTissue& tissue, const BeamMaterials& per_mm, bool texture,
                 int num_threads, std::optional<std::uint64_t> organs = {});

  const kernels::AcousticVoxels& voxels() const { return view_; }

  /// Unit normal of the boundary at a place (voxel indices), in mm along the voxel axes, towards
  /// the higher zeta = ln(Z) / 2: from the slopes there and four voxels around. Zero where there is
  /// no slope. @pre finite.
  Eigen::Vector3d NormalAt(const Eigen::Vector3d& index) const;

  std::size_t bytes() const { return packed_.size() * sizeof(packed_[0]); }

 private:
  /// Places of the voxels around one, every second along each axis: offsets into packed_.
  struct Around {
    static constexpr int kPlaces = 7;
    int at[3][kPlaces];
  };
  Around AroundOf(const Eigen::Array3i& voxel) const;
  /// Difference of zeta's codes over four voxels along each axis, per spacing, at a place of
  /// `around`.
  Eigen::Vector3f DifferenceAt(const Around& around, const Eigen::Array3i& place) const;

  std::vector<std::uint32_t> packed_;
  kernels::AcousticVoxels view_{};
  Eigen::Array3i first_;  ///< Of the box, in voxels of the grid.
  Eigen::Array3i size_;   ///< Of the box.
  Eigen::Array3f per_spacing_mm_;
};

}  // namespace acus::ultrasound
