// Where the voxels of a volume are: patient coordinates LPS, mm, as in ITK and DICOM.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>

namespace acus::volume {

/// A regular grid. Voxel (0, 0, 0) has its *centre* at origin_mm; index i runs fastest in memory.
struct Geometry {
  Eigen::Array3i size = Eigen::Array3i::Zero();         ///< Voxels along i, j, k.
  Eigen::Array3d spacing_mm = Eigen::Array3d::Ones();   ///< Distance of centres along i, j, k; > 0.
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();  ///< LPS.
  Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();  ///< Columns: unit axes i, j, k in LPS.

  std::size_t num_voxels() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  double voxel_volume_mm3() const { return spacing_mm.prod(); }
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
  bool Contains(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
  /// x_ct_mm = ct_from_index * continuous index (0 = centre of the first voxel).
  Eigen::Affine3d ct_from_index() const;
  Eigen::Affine3d index_from_ct() const;

  /// Same size, and voxel centres within `tolerance_mm` of each other.
  bool Matches(const Geometry& other, double tolerance_mm = 0.01) const;
};

}  // namespace acus::volume
