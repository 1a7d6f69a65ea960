// Slopes of a CT at its voxels, for light: three bytes each, so that a ray reads them as they are
// instead of taking differences.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::volume_rendering {

/// Central differences of a CT over 1.5 mm to either side: voxels and noise are no surfaces. Air is
/// beyond the border.
class SlopeVolume {
 public:
  /// Steeper ones are stored as this steep.
  static constexpr float kSteepest = 160.0F;
  /// HU/mm of one unit.
  static constexpr float kUnit = kSteepest / 127.0F;

  SlopeVolume() = default;
  /// The same bits with any number of threads.
  SlopeVolume(const volume::CtVolume& ct, int num_threads);

  /// HU/mm along the axes of the grid, trilinear.
  /// @param index  A place within the grid, in voxels.
  Eigen::Vector3f At(const Eigen::Vector3f& index) const noexcept;

  /// For the kernel: x, y, z of each voxel and one byte more, in kUnit; i fastest.
  const std::int8_t* units() const noexcept { return units_.data(); }

 private:
  void FillRow(const volume::CtVolume& ct, int j, int k);

  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  Eigen::Array3f reach_ = Eigen::Array3f::Zero();  ///< In voxels.
  Eigen::Array3f per_hu_ = Eigen::Array3f::Zero();
  std::vector<std::int8_t> units_;
};

}  // namespace acus::volume_rendering
