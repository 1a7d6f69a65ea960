// Deformation of a finished image: pixels are displaced, whatever they show (Alamilla-2021,
// section V.B).
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/slicing/beam_bend.h"

namespace acus::ultrasound {

/// Not for two threads at a time: it holds buffers.
class PixelShift {
 public:
  /// Each pixel takes the grey of the place in the image where its tissue was at rest, projected
  /// onto the plane; black where that is beyond the image. The map is evaluated at knots of its
  /// SpacingMm(). Bilinear. Allocates only if the size or the spacing changes.
  void Apply(const image::ImageGeometry& geometry, const Eigen::Isometry3d& ct_from_probe,
             const slicing::RestMap& rest, image::GrayImage& image);

 private:
  std::vector<std::uint8_t> before_;
  std::vector<Eigen::Vector2d> at_knot_;  ///< Offset in pixels (column, row), row by row.
};

/// The needle as a shape at rest: displaced with the image, it lies where it is.
image::NeedleInImage NeedleAtRest(const image::NeedleInImage& needle, const slicing::RestMap& rest);

}  // namespace acus::ultrasound
