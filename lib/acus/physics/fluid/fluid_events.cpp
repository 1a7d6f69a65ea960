#include "acus/physics/fluid/fluid_events.h"

#include <algorithm>
#include <cmath>

namespace acus::fluid {
namespace {

/// No drop for so long: the rate is 0.
constexpr double kDryS = 120.0;
/// A fall begins at this share of the highest pressure.
constexpr double kHighShare = 0.9;

void FollowPressure(FluidEvents& events, const FluidEventLimits& limits, const FluidOutput& output,
                    double dt_s) noexcept {
  const double kpa = output.syringe_kpa;
  events.peak_kpa = std::max(events.peak_kpa, kpa);
  if (kpa > limits.high_kpa) events.above_limit_s += dt_s;
  // A new top, or a fall so slow that it is a thumb that lets go.
  if (kpa >= events.top_kpa || events.since_high_s > limits.within_s) {
    events.top_kpa = kpa;
    events.armed = kpa >= limits.armed_kpa;
  }
  if (kpa >= kHighShare * events.top_kpa) {
    events.since_high_s = 0.0;
    events.since_high_ml = 0.0;
    return;
  }
  events.since_high_s += dt_s;
  events.since_high_ml += std::max(0.0, output.flow_ml_per_s) * dt_s;
  const bool has_fallen = kpa <= (1.0 - limits.fall_share) * events.top_kpa;
  if (events.armed && has_fallen && events.since_high_ml >= limits.injected_ml) {
    events.lost_resistance = true;
    events.before_loss_kpa = events.top_kpa;
    events.fall_time_s = events.since_high_s;
    ++events.num_losses;
    events.armed = false;
  }
}

void CountDrops(FluidEvents& events, const FluidOutput& output, double dt_s) noexcept {
  events.drop_ml += output.hub_ml_per_s * dt_s;
  events.since_drop_s += dt_s;
  if (events.drop_ml >= kDropMl) {
    const double drops = std::floor(events.drop_ml / kDropMl);
    events.num_drops += static_cast<int>(drops);
    events.drops_per_min = 60.0 * drops / events.since_drop_s;
    events.drop_ml -= drops * kDropMl;
    events.since_drop_s = 0.0;
  } else if (events.since_drop_s > kDryS) {
    events.drops_per_min = 0.0;
  }
}

}  // namespace

void FluidEvents::Advance(const FluidEventLimits& limits, const FluidOutput& output,
                          double dt_s) noexcept {
  lost_resistance = false;
  FollowPressure(*this, limits, output, dt_s);
  CountDrops(*this, output, dt_s);
}

}  // namespace acus::fluid
