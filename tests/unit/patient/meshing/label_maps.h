// Label maps with known truth, for the tests of this folder.
#pragma once

#include <functional>

#include "acus/data/volume/volume.h"

namespace acus::meshing::label_maps {

constexpr std::uint8_t kSkin = 1, kFat = 2, kBone = 5, kLiver = 8;

/// Cubic voxels; label_at gets the voxel's centre in mm from the middle of the volume.
inline volume::LabelMap Make(int side, double spacing_mm,
                             const std::function<std::uint8_t(const Eigen::Vector3d&)>& label_at) {
  volume::Geometry g;
  g.size.setConstant(side);
  g.spacing_mm.setConstant(spacing_mm);
  g.origin_mm = -0.5 * spacing_mm * (side - 1) * Eigen::Vector3d::Ones();
  volume::LabelMap out(g);
  out.names = {{kSkin, "skin"}, {kFat, "fat"}, {kBone, "bone"}, {kLiver, "liver"}};
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        out.At(i, j, k) = label_at(g.origin_mm + spacing_mm * Eigen::Vector3d(i, j, k));
      }
    }
  }
  return out;
}

/// A ball of fat with a 3 mm skin, a ball of bone inside and one of liver beside it.
inline volume::LabelMap NestedBalls() {
  return Make(60, 1.5, [](const Eigen::Vector3d& x) -> std::uint8_t {
    if ((x - Eigen::Vector3d(12, 0, 0)).norm() < 10.0) return kBone;
    if ((x + Eigen::Vector3d(14, 0, 0)).norm() < 11.0) return kLiver;
    const double r = x.norm();
    return r < 35.0 ? kFat : r < 38.0 ? kSkin : 0;
  });
}

/// Tissue fills the volume to its border; a bar of bone runs through it and out at both ends.
inline volume::LabelMap BarToTheBorder() {
  return Make(40, 2.0, [](const Eigen::Vector3d& x) -> std::uint8_t {
    return std::hypot(x[1] - 5.0, x[2]) < 12.0 ? kBone : kFat;
  });
}

}  // namespace acus::meshing::label_maps
