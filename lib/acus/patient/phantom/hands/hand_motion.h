// How hands move: smooth strokes with tremor.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace acus::phantom {

/// Minimum-jerk stroke (Flash & Hogan 1985): 0 to 1 as `fraction` of the time goes from 0 to 1,
/// with no speed and acceleration at either end. Constant beyond.
double MinimumJerk(double fraction);

/// Time of a minimum-jerk stroke over `length` whose highest speed is `peak_speed`; at least 0.35
/// s, which bounds the acceleration of short strokes. 0 for no length.
double StrokeDurationS(double length, double peak_speed);

/// Noise in a band of frequencies with a given root mean square: a sum of sines whose frequencies
/// and phases belong to (seed, name). Physiological tremor of the hand lies at 8 to 12 Hz.
class BandNoise {
 public:
  /// @pre 0 < low_hz < high_hz
  BandNoise(std::uint64_t seed, std::string_view name, double low_hz, double high_hz, double rms);
  double At(double time_s) const;

 private:
  struct Wave {
    double omega_rad_per_s;
    double phase_rad;
  };
  std::vector<Wave> waves_;
  double amplitude_;
};

}  // namespace acus::phantom
