// A CT whose content is a function of place, for tests with a known truth.
#pragma once

#include <cmath>
#include <cstdint>

#include "acus/data/volume/volume.h"

namespace acus::testing_support {

/// Voxel = hu(x_mm, y_mm, z_mm) at its centre; the first centre is the origin of LPS.
template <typename Function>
volume::CtVolume SyntheticCt(const Eigen::Array3i& size, double spacing_mm, const Function& hu) {
  volume::Geometry geometry;
  geometry.size = size;
  geometry.spacing_mm.setConstant(spacing_mm);
  volume::CtVolume ct(geometry);
  std::size_t n = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        ct.voxels[n++] = static_cast<std::int16_t>(
            std::lround(hu(i * spacing_mm, j * spacing_mm, k * spacing_mm)));
      }
    }
  }
  return ct;
}

}  // namespace acus::testing_support
