#include "acus/scene/effects/peristalsis/contraction_wave.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::effects {

ContractionWave::ContractionWave(double waves_per_min, double speed_mm_per_s, double length_mm,
                                 double contraction)
    : period_s_(60.0 / waves_per_min),
      spacing_mm_(speed_mm_per_s * period_s_),
      length_share_(length_mm / spacing_mm_),
      contraction_(contraction) {
  ACUS_REQUIRE(waves_per_min > 0.0 && speed_mm_per_s > 0.0 && length_mm > 0.0 &&
                   std::isfinite(spacing_mm_) && contraction >= 0.0 && contraction <= 0.9,
               "waves of ", waves_per_min, " per minute, ", speed_mm_per_s, " mm/s, ", length_mm,
               " mm long, with a contraction of ", contraction,
               "; numbers above 0 and a contraction from 0 to 0.9 are allowed");
  ACUS_REQUIRE(length_share_ <= 1.0, "contractions ", length_mm, " mm long come every ",
               spacing_mm_, " mm; give a smaller length_mm or rate, or a larger speed");
}

double ContractionWave::WavesAt(double session_s) const noexcept {
  const double waves = session_s / period_s_;
  return std::isfinite(waves) ? waves : 0.0;
}

double ContractionWave::StrainAt(double along_mm, double waves) const noexcept {
  const double since = waves - along_mm / spacing_mm_;
  const double phase = since - std::floor(since);
  if (!(phase < length_share_)) return 0.0;
  return -0.5 * contraction_ * (1.0 - std::cos(2.0 * std::numbers::pi * phase / length_share_));
}

}  // namespace acus::effects
