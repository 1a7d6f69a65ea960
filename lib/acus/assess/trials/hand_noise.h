// Deviations of a hand from its intended pose: tremor and drift.
#pragma once

#include <Eigen/Core>
#include <array>

#include "acus/base/core/random.h"

namespace acus::trials {

/// A sum of sines of random phase with frequencies in a band, for each of three axes: the same
/// function of time for any step.
class BandNoise {
 public:
  /// @param rms  Along each axis, in any unit; >= 0. @pre 0 < low_hz <= high_hz.
  BandNoise(double rms, double low_hz, double high_hz, RandomStream& random);

  Eigen::Vector3d At(double time_s) const;

 private:
  static constexpr int kSines = 5;
  double amplitude_ = 0.0;  ///< Amplitude of each sine.
  std::array<std::array<double, kSines>, 3> omega_rad_per_s_{};
  std::array<std::array<double, kSines>, 3> phase_rad_{};
};

}  // namespace acus::trials
