#include "acus/physics/forces/laws/hard_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::forces {
namespace {

constexpr double kLog100 = 4.605170185988091;
constexpr double kLeastTravelPerStepMm =
    0.02;  // Per step, that a hand which seems to rest may make.

}  // namespace

void HardContact::Strike(const HardContactSettings& settings, double speed_mm_per_s) noexcept {
  if (!(speed_mm_per_s > 0.0) || settings.amplitude_n_s_per_mm <= 0.0) return;
  if (running) {
    const double left_mm_per_s =
        impact_mm_per_s * std::exp(-kLog100 * elapsed_s / settings.duration_s);
    if (left_mm_per_s >= speed_mm_per_s) return;
  }
  running = true;
  impact_mm_per_s = speed_mm_per_s;
  elapsed_s = 0.0;
}

double HardContact::NominalN(const HardContactSettings& settings) const noexcept {
  if (!running || elapsed_s <= 0.0 || elapsed_s >= settings.duration_s) return 0.0;
  return settings.amplitude_n_s_per_mm * impact_mm_per_s *
         std::exp(-kLog100 * elapsed_s / settings.duration_s) *
         std::sin(2.0 * std::numbers::pi * settings.frequency_hz * elapsed_s);
}

double HardContact::Advance(const HardContactSettings& settings, double travel_mm, double dt_s,
                            double spring_n, double largest_n) noexcept {
  if (!running) return 0.0;
  account_n_mm += applied_n * travel_mm;
  elapsed_s += dt_s;
  if (elapsed_s >= settings.duration_s) {
    Stop();
    return 0.0;
  }
  if (settings.without_account) {
    applied_n = NominalN(settings);
    return applied_n;
  }
  double force_n = std::clamp(spring_n + NominalN(settings), 0.0, largest_n) - spring_n;
  // Against the motion it takes energy; along it, what the next step may cost must be on the
  // account.
  if (force_n * travel_mm <= 0.0) {
    const double cost_n_mm =
        std::abs(force_n) * std::max(std::abs(travel_mm), kLeastTravelPerStepMm);
    force_n *= cost_n_mm > 0.0 ? std::clamp(account_n_mm / (2.0 * cost_n_mm), 0.0, 1.0) : 0.0;
  }
  applied_n = force_n;
  return force_n;
}

}  // namespace acus::forces
