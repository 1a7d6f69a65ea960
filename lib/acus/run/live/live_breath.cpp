#include "acus/run/live/live_breath.h"

#include <algorithm>
#include <cmath>

#include "acus/physics/breathing/breath_source.h"

namespace acus::live {
namespace {

constexpr double kRampS = breathing::BreathClock::kRampS;
constexpr double kLongestStepS = 1.0;  // After a longer pause, breath keeps its phase.
constexpr double kReturnS = 0.5;       // To return to the belt's level after a hold.

}  // namespace

double LiveBreath::Advance(double dt_s) noexcept {
  const double wanted = holds_ ? 0.0 : 1.0;
  const double ramp_s = std::min(dt_s, std::abs(wanted - speed_) * kRampS);
  const double before = speed_;
  speed_ = ramp_s < dt_s
               ? wanted
               : std::clamp(before + (wanted > before ? ramp_s : -ramp_s) / kRampS, 0.0, 1.0);
  return 0.5 * (before + speed_) * ramp_s + wanted * (dt_s - ramp_s);
}

breathing::Breath LiveBreath::OfBelt(double session_s, double dt_s, double passed_s) noexcept {
  breathing::Breath breath = belt_.At(session_s);
  if (speed_ < 1.0) {
    // The belt's rate, scaled by the remaining speed of the breath.
    offset_ = level_ + breath.level_per_s * passed_s - breath.level;
    breath.level_per_s *= speed_;
  } else {
    offset_ *= std::exp(-dt_s / kReturnS);
    breath.level_per_s -= offset_ / kReturnS;
  }
  breath.level += offset_;
  level_ = breath.level;
  return breath;
}

session::BreathSample LiveBreath::Step(double session_s) noexcept {
  const double dt_s = started_ ? std::clamp(session_s - last_s_, 0.0, kLongestStepS) : 0.0;
  started_ = true;
  last_s_ = session_s;
  const double passed_s = Advance(dt_s);
  breath_s_ += passed_s;
  session::BreathSample sample;
  breathing::Breath breath;
  if (has_belt_) {
    breath = OfBelt(session_s, dt_s, passed_s);
    sample.status = belt_.StatusAt(session_s);
  } else {
    breath = partner_.NormalAt(breath_s_);
    breath.level_per_s *= speed_;
  }
  if (holds_ || speed_ < 1.0) sample.status = session::BreathStatus::kHeld;
  sample.cycle = breath.cycle;
  sample.level = breath.level;
  sample.level_per_s = breath.level_per_s;
  return sample;
}

}  // namespace acus::live
