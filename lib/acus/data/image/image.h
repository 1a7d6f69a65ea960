// Grey images, and where their pixels are in the probe's frame and in the CT.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "acus/base/math/polyline.h"

namespace acus::image {

/// pixels[row * width + column], 0 = black. Row 0 is at the probe's face, column 0 on its -x side.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  /// Allocates only if the size changes.
  void Resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  std::uint8_t At(int column, int row) const {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(column)];
  }
};

/// rgb[3 * (row * width + column)], sRGB.
struct ColourImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  /// Allocates only if the size changes.
  void Resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
};

/// An image in the probe's plane: columns run along +x (the marked side), rows along +y (depth).
/// The centre of pixel (c, r) is at x = (c - (width_px - 1) / 2) * lateral_mm_per_px and
/// y = depth_of_top_row_mm + r * axial_mm_per_px.
struct ImageGeometry {
  int width_px = 0;
  int height_px = 0;
  double lateral_mm_per_px = 1.0;
  double axial_mm_per_px = 1.0;
  double depth_of_top_row_mm = 0.0;  ///< 0: the middle of the top row is the probe's origin.

  /// x_probe_mm = probe_from_image * (column, row, 0). The third column, along the probe's z, has
  /// the lateral scale, so that the map can be inverted.
  Eigen::Affine3d probe_from_image() const;
  Eigen::Affine3d ct_from_image(const Eigen::Isometry3d& ct_from_probe) const {
    return Eigen::Affine3d(ct_from_probe) * probe_from_image();
  }
};

/// A needle as an image sees it: a cylinder with a sharp tip, straight unless it has a shape.
struct NeedleInImage {
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit, from the hub to the tip.
  double length_mm = 0.0;
  double radius_mm = 0.0;
  /// From the tip to the hub, in CT space. With two points or more it takes the place of tip, axis
  /// and length.
  math::Polyline shape = {};
};

/// Floats that vector instructions load and store at full speed: aligned to 64 bytes.
class AlignedFloats {
 public:
  /// Keeps what it has if that is enough. The content is undefined afterwards.
  void Reserve(std::size_t count) {
    if (count <= capacity_) return;
    data_.reset(static_cast<float*>(::operator new (count * sizeof(float), std::align_val_t{64})));
    capacity_ = count;
  }
  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }
  std::size_t capacity() const { return capacity_; }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<float[], Free> data_;
  std::size_t capacity_ = 0;
};

}  // namespace acus::image
