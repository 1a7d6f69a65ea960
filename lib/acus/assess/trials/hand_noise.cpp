#include "acus/assess/trials/hand_noise.h"

#include <cmath>
#include <numbers>

namespace acus::trials {

BandNoise::BandNoise(double rms, double low_hz, double high_hz, RandomStream& random)
    : amplitude_(rms * std::sqrt(2.0 / kSines)) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t sine = 0; sine < kSines; ++sine) {
      omega_rad_per_s_[axis][sine] = kTurn * random.Uniform(low_hz, high_hz);
      phase_rad_[axis][sine] = random.Uniform(0.0, kTurn);
    }
  }
}

Eigen::Vector3d BandNoise::At(double time_s) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t sine = 0; sine < kSines; ++sine) {
      sum[static_cast<Eigen::Index>(axis)] +=
          amplitude_ * std::sin(omega_rad_per_s_[axis][sine] * time_s + phase_rad_[axis][sine]);
    }
  }
  return sum;
}

}  // namespace acus::trials
