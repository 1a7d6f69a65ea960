// What goes over the network with its place: an ultrasound image, a camera's view, a CT, points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace acus::tracking {

/// Grey or RGB, 8 bits, rows from the top, no gaps.
struct Image {
  int width = 0;                          ///< 1 to 65535.
  int height = 0;                         ///< 1 to 65535.
  int channels = 1;                       ///< 1 or 3.
  std::vector<std::uint8_t> pixels = {};  ///< width x height x channels.
  /// From pixel (column, row, 0, 1) of pixel centres to mm in the reference frame; its columns are
  /// as long as a pixel is large.
  Eigen::Matrix4d reference_from_pixel = Eigen::Matrix4d::Identity();
};

/// A volume of another owner, such as a CT or a label map.
struct VolumeView {
  std::array<int, 3> size = {};  ///< Along i, j, k; each 1 to 65535.
  /// HU, or labels; index i runs fastest.
  std::variant<std::span<const std::int16_t>, std::span<const std::uint8_t>> voxels;
  /// From voxel (i, j, k) of voxel centres to mm, in the frame in which receivers show it: RAS.
  Eigen::Matrix4d ras_from_voxel = Eigen::Matrix4d::Identity();
};

struct NamedPoint {
  std::string name;  ///< Its first 64 characters are sent.
  Eigen::Vector3d ras_mm = Eigen::Vector3d::Zero();
  double diameter_mm = 0.0;
};

}  // namespace acus::tracking
