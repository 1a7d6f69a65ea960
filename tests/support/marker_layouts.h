// Markers for tests of registration, with known poses and noise.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "acus/base/core/random.h"

namespace acus::testing_support {

inline Eigen::Isometry3d KnownPose() {
  return Eigen::Translation3d(120.0, -35.0, 840.0) *
         Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized());
}

/// Uniform in a cube of 200 mm.
inline Eigen::Matrix3Xd SpreadMarkers(int count, std::uint64_t seed = 7) {
  RandomStream random(seed, "markers");
  Eigen::Matrix3Xd markers_mm(3, count);
  for (double& x : markers_mm.reshaped()) x = random.Uniform(-100, 100);
  return markers_mm;
}

/// With isotropic normal errors of RMS length fle_rms_mm.
inline Eigen::Matrix3Xd NoisyMarkers(Eigen::Matrix3Xd markers_mm, double fle_rms_mm,
                                     std::uint64_t index) {
  RandomStream random(3, "noise", index);
  for (double& x : markers_mm.reshaped()) x += fle_rms_mm / std::sqrt(3.0) * random.Normal();
  return markers_mm;
}

}  // namespace acus::testing_support
