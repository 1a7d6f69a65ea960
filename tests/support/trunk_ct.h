// A trunk for volume rendering: what images of a patient are timed and compared on.
#pragma once

#include <cmath>
#include <memory>

#include "acus/data/volume/volume.h"

namespace acus::testing_support {

/// 360 x 260 x 300 mm with ribs, noise and a backbone, `per_axis` voxels along each axis: with 256
/// as large as the paper's small CT.
inline std::shared_ptr<volume::CtVolume> TrunkCt(int per_axis) {
  volume::Geometry grid;
  grid.size.setConstant(per_axis);
  grid.spacing_mm = Eigen::Array3d(382.5, 306.0, 306.0) / (per_axis - 1);
  grid.origin_mm = -0.5 * (per_axis - 1) * grid.spacing_mm.matrix();
  auto ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{-1000});
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  for (int k = 0; k < per_axis; ++k) {
    for (int j = 0; j < per_axis; ++j) {
      for (int i = 0; i < per_axis; ++i) {
        const Eigen::Vector3d p = ct_from_index * Eigen::Vector3d(i, j, k);
        const double shell = std::hypot(p[0] / 170.0, p[1] / 120.0);
        if (shell > 1.0 || std::abs(p[2]) > 140.0) continue;
        const bool rib =
            shell > 0.85 && shell < 0.92 && std::fmod(p[2] + 150.0 - 0.3 * p[1], 24.0) < 8.0;
        const bool spine = std::hypot(p[0], p[1] - 75.0) < 18.0;
        const int noise = static_cast<int>((i * 31 + j * 17 + k * 7) % 23) - 11;
        ct->At(i, j, k) = static_cast<std::int16_t>((rib || spine   ? 700
                                                     : shell > 0.93 ? -90
                                                                    : 50) +
                                                    noise);
      }
    }
  }
  return ct;
}

}  // namespace acus::testing_support
