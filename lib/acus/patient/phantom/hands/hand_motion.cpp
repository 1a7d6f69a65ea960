#include "acus/patient/phantom/hands/hand_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::phantom {

double MinimumJerk(double fraction) {
  const double t = std::clamp(fraction, 0.0, 1.0);
  return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

double StrokeDurationS(double length, double peak_speed) {
  constexpr double kShortestS = 0.35;
  constexpr double kPeakOverMean = 1.875;  // Of the minimum-jerk profile.
  const double way = std::abs(length);
  return way > 0.0 ? std::max(kPeakOverMean * way / peak_speed, kShortestS) : 0.0;
}

BandNoise::BandNoise(std::uint64_t seed, std::string_view name, double low_hz, double high_hz,
                     double rms) {
  ACUS_ASSERT(0.0 < low_hz && low_hz < high_hz);
  constexpr int kWaves = 24;
  RandomStream random(seed, name);
  for (int i = 0; i < kWaves; ++i) {
    // One wave in each part of the band: no gaps, no beats that last for ever.
    const double hz = low_hz + (high_hz - low_hz) * (i + random.Uniform()) / kWaves;
    waves_.push_back({2.0 * std::numbers::pi * hz, 2.0 * std::numbers::pi * random.Uniform()});
  }
  amplitude_ = rms * std::sqrt(2.0 / kWaves);
}

double BandNoise::At(double time_s) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += std::sin(wave.omega_rad_per_s * time_s + wave.phase_rad);
  return amplitude_ * sum;
}

}  // namespace acus::phantom
