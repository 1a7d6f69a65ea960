// The spinal canal as a tube along the spine: found where the arch of a vertebra closes around it,
// carried on through the windows between the arches.
//
// All volumes here have patient axes (lps_axes.h). Lengths in a slice are along its axes: u = i
// times spacing (to the left), v = j times spacing (to the back), mm.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// A hole in a ring of bone in one axial slice that looks like the spinal canal.
struct CanalHole {
  int k = 0;
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();  ///< (u, v).
  double area_mm2 = 0.0;
  double from_middle_mm = 0.0;  ///< Across, from the middle of the bone nearby.
};

/// The holes of all slices that are as large and as round as a canal, hold no marrow, and have
/// denser tissue (a vertebral body) in front, at most 55 mm beside the median of the bone within
/// 60 mm above and below: the marrow of hips looks alike. `shell`: bone with its small gaps closed.
std::vector<CanalHole> FindCanalHoles(const volume::CtVolume& ct, const Mask& shell,
                                      int num_threads);

/// The longest chain of holes, at most one in a slice, that one spine can pass through; holes
/// beside the middle count for less. Empty if that is shorter than 14 mm.
std::vector<CanalHole> CanalChain(const std::vector<CanalHole>& holes, const volume::Geometry& g);

inline constexpr int kNumCanalRays = 48;

/// Centre and radius of the canal in each slice from `first` on.
struct CanalTube {
  int first = 0;                           ///< Slice k.
  std::vector<Eigen::Vector2d> centre_mm;  ///< (u, v), by slice.
  /// By slice, then by angle 2 pi n / kNumCanalRays from +u to +v.
  std::vector<std::array<double, kNumCanalRays>> radius_mm;
  std::vector<std::uint8_t> is_closed;  ///< By slice: 1 if a ring of bone closes around it.

  int last() const { return first + static_cast<int>(centre_mm.size()) - 1; }
  bool Has(int k) const { return k >= first && k <= last(); }
  const Eigen::Vector2d& Centre(int k) const {
    return centre_mm[static_cast<std::size_t>(k - first)];
  }
  /// The radius towards (u, v) from the centre of slice k, mm. @pre Has(k).
  double RadiusMm(int k, const Eigen::Vector2d& from_centre_mm) const;
};

/// The tube through a chain. Its radius in each direction is measured to the inner edge of the
/// bone (half of the edge's height, between voxels) in the slices of the chain; elsewhere, and
/// against outliers, it is the weighted median of the slices nearby.
CanalTube FitCanalTube(const volume::CtVolume& ct, const std::vector<CanalHole>& chain,
                       double bone_hu);

/// The voxels within the tube, without bone, and without muscle, ligament or disc in its rim.
Mask CanalMask(const CanalTube& tube, const volume::CtVolume& ct, double bone_hu);

/// What lines the canal: the voxels of the tube above `fat_upper_hu` that are neither `bone` nor
/// canal. That is flavum and posterior longitudinal ligament; no muscle lies inside the canal.
Mask CanalLining(const CanalTube& tube, const volume::CtVolume& ct, const Mask& bone,
                 const Mask& canal, double fat_upper_hu);

}  // namespace acus::segmentation
