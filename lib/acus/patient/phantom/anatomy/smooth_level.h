// A smooth surface through a body of voxels, as the zero of a function.
#pragma once

#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::phantom {

/// About the signed distance to a surface, mm: < 0 inside. A cubic B-spline on a grid whose axes
/// are those of CT space, so that value and gradient are smooth everywhere; beyond the grid as at
/// its border. A value; const access from any number of threads.
class SmoothLevel {
 public:
  struct Sample {
    double level_mm = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< About a unit vector, outwards.
  };

  SmoothLevel() = default;
  /// @param inside    1 in the body, 0 outside.
  /// @param sigma_mm  Of the Gaussian that takes the stairs of the voxels off the surface.
  /// @param offset_mm  By which the body is made smaller after that.
  /// @throws InputError if the axes of the grid are not those of CT space, it has fewer than four
  ///     voxels along an axis, or nothing or everything is inside.
  SmoothLevel(const volume::Grid<std::uint8_t>& inside, double sigma_mm, double offset_mm,
              int num_threads);

  Sample At(const Eigen::Vector3d& point_ct_mm) const noexcept;
  double LevelMm(const Eigen::Vector3d& point_ct_mm) const noexcept {
    return At(point_ct_mm).level_mm;
  }

  const volume::Geometry& geometry() const { return coefficients_.geometry; }

 private:
  volume::Grid<float> coefficients_;
};

}  // namespace acus::phantom
