// The needle under X-rays: how much metal each ray crosses.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/fluoroscopy/c_arm.h"

namespace acus::fluoroscopy {

/// Length of a straight line inside a cylinder with flat ends, mm.
/// @param direction  Unit, of the line through `origin_mm`; only what lies ahead of it counts.
double CylinderChordMm(const Eigen::Vector3d& origin_mm, const Eigen::Vector3d& direction,
                       const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm,
                       double radius_mm);

/// Adds the shadow of a solid needle to sums of attenuation: per pixel the mean intensity over 4 x
/// 4 rays behind chords times `metal_per_mm`, as a sum again. Allocates only if the needle covers
/// more of the image than before.
class NeedleShadow {
 public:
  /// @param sums  One per pixel of the C-arm's image, row by row with `stride`.
  void Add(const image::NeedleInImage& needle, const CArm& c_arm, const CArmGeometry& geometry,
           float* sums, int stride);

 private:
  std::vector<int> pixels_;         ///< That a piece of the needle may darken.
  std::vector<std::uint8_t> seen_;  ///< Of each pixel, if it is in the list.
};

}  // namespace acus::fluoroscopy
