// A picture that goes over the network with its place: an ultrasound image, a camera's view.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace acus::tracking {

/// Grey or RGB, 8 bits, rows from the top, no gaps.
struct Picture {
  int width = 0;                          ///< 1 to 65535.
  int height = 0;                         ///< 1 to 65535.
  int channels = 1;                       ///< 1 or 3.
  std::vector<std::uint8_t> pixels = {};  ///< width x height x channels.
  /// From pixel (column, row, 0, 1) of pixel centres to mm in the reference frame; its columns are
  /// as long as a pixel is large.
  Eigen::Matrix4d reference_from_pixel = Eigen::Matrix4d::Identity();
};

}  // namespace acus::tracking
