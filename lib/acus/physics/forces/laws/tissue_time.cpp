#include "acus/physics/forces/laws/tissue_time.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

/// Off the tip: returns to its home, or to the tip if that is met before.
double ReturnedMm(double rest_mm, const TipMove& move, double home_mm, double time_s) noexcept {
  const double free_mm = home_mm + (rest_mm - home_mm) * std::exp(-move.dt_s / time_s);
  if (move.to_mm <= free_mm) return free_mm;
  const double speed = (move.to_mm - move.from_mm) / move.dt_s;
  if (speed <= 0.0) return move.to_mm;
  const double gap_mm = rest_mm - move.from_mm;
  const double pressed_s = move.dt_s * (1.0 - gap_mm / (gap_mm + move.to_mm - free_mm));
  return move.to_mm + speed * time_s * std::expm1(-pressed_s / time_s);
}

}  // namespace

double ForceRelaxation::ElasticShare() const noexcept {
  double elastic = 1.0;
  for (int k = 0; k < num_terms; ++k) elastic -= share[k];
  return elastic;
}

double FrictionTime::RateLog(double speed_mm_per_s) const noexcept {
  return std::log((std::abs(speed_mm_per_s) + least_mm_per_s) /
                  (reference_mm_per_s + least_mm_per_s));
}

double FrictionTime::DwellLog(double age_s) const noexcept {
  return std::log((age_s + least_dwell_s) / (slip_mm / reference_mm_per_s + least_dwell_s));
}

double CreptMm(double rest_mm, const TipMove& move, double home_mm, double time_s) noexcept {
  const double pressed_mm = move.from_mm - rest_mm;
  if (pressed_mm < 0.0) return ReturnedMm(rest_mm, move, home_mm, time_s);
  const double steady_mm = (move.to_mm - move.from_mm) / move.dt_s * time_s;
  const double then_mm = steady_mm + (pressed_mm - steady_mm) * std::exp(-move.dt_s / time_s);
  if (then_mm >= 0.0) return move.to_mm - then_mm;
  // It comes off during withdrawal.
  const double off_s = std::min(move.dt_s, time_s * std::log1p(-pressed_mm / steady_mm));
  const double off_mm = move.from_mm + steady_mm / time_s * off_s;
  const double left_s = move.dt_s - off_s;
  if (!(left_s > 0.0)) return move.to_mm;
  return ReturnedMm(off_mm, {off_mm, move.to_mm, left_s}, home_mm, time_s);
}

}  // namespace acus::forces
