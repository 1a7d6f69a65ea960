// Where the discs of a spine are: planes across the column of vertebral bodies.
#pragma once

#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// A line along the middle of the spinal canal, from the feet to the head, by arc length.
struct CanalLine {
  double step_mm = 1.0;
  /// To the left, the back and the head: those of the grid, which may be oblique.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Vector3d> points_mm;  ///< CT.
  std::vector<Eigen::Vector3d> forward;    ///< Unit vectors to the vertebral bodies.
  std::vector<Eigen::Vector3d> tangent;    ///< Unit vectors to the head.

  /// Lateral unit vector at a point, to the patient's left.
  Eigen::Vector3d Left(std::size_t at) const { return forward[at].cross(tangent[at]); }
};

/// Through the voxels labelled spinal_canal, smoothed over 15 mm. Empty if they span less than
/// 30 mm towards the head.
CanalLine CanalLineOf(const volume::LabelMap& tissues);

/// The middle plane of a disc.
struct DiscPlane {
  Eigen::Vector3d point_mm;  ///< CT, on the canal's line.
  Eigen::Vector3d normal;    ///< Unit vector, towards the head.
  double contrast_hu = 0.0;  ///< End plates over disc.
  int step = 0;              ///< Of the canal's line.
};

/// The discs along a canal, from the feet to the head. Each is where the HU of the column, taken
/// over a plane, are lower than those 1.5 to 7 mm above and below (the end plates), at the tilt at
/// which they are so most; of all sequences the one with the most contrast whose distances are 14
/// to 46 mm and change slowly along the spine (dynamic programming).
std::vector<DiscPlane> FindDiscPlanes(const volume::CtVolume& ct, const CanalLine& canal);

}  // namespace acus::segmentation
