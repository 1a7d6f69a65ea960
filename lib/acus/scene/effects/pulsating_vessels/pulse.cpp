#include "acus/scene/effects/pulsating_vessels/pulse.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

/// The duration of diastole in time constants of the exponential run-off. With 3, the wall falls by
/// two thirds in the first third of diastole.
constexpr double kRunOff = 3.0;

}  // namespace

Pulse::Pulse(double beats_per_min, double rise_share)
    : period_s_(60.0 / beats_per_min), rise_share_(rise_share) {
  ACUS_REQUIRE(beats_per_min > 0.0 && beats_per_min <= 300.0, "a heart rate of ", beats_per_min,
               " beats a minute; above 0 and up to 300 is allowed");
  ACUS_REQUIRE(rise_share > 0.0 && rise_share < 1.0, "the rise of the pulse takes ", rise_share,
               " of the cycle; between 0 and 1 is allowed");
}

double Pulse::At(double session_s) const noexcept {
  const double cycles = session_s / period_s_;
  if (!std::isfinite(cycles)) return 0.0;
  const double phase = cycles - std::floor(cycles);
  if (phase < rise_share_) return 0.5 * (1.0 - std::cos(std::numbers::pi * phase / rise_share_));
  const double end = std::exp(-kRunOff);
  const double fallen = (phase - rise_share_) / (1.0 - rise_share_);
  return (std::exp(-kRunOff * fallen) - end) / (1.0 - end);
}

}  // namespace acus::effects
