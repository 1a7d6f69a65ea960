#include "acus/run/live/belt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::live {
namespace {

// At 30 readings a second of a breath of 4 s, the lag stays below 40 ms and noise is halved.
constexpr double kAlpha = 0.5;
constexpr double kBeta = 0.15;
constexpr double kMostRatePerS = 20.0;  // An upper bound of the rate of breath, 1/s.

}  // namespace

void BeltFollower::Read(double time_s, double level) noexcept {
  const bool is_breath = std::isfinite(time_s) && std::abs(level) <= kMostLevel;
  if (!is_breath || (num_readings_ > 0 && time_s <= time_s_)) {
    ++num_rejected_;
    return;
  }
  const double dt_s = time_s - time_s_;
  if (num_readings_ == 0 || dt_s > kPredictS + kSlowS) {
    level_ = level;
    level_per_s_ = 0.0;
  } else {
    const double expected = level_ + level_per_s_ * dt_s;
    const double residual = level - expected;
    level_ = expected + kAlpha * residual;
    level_per_s_ = std::clamp(level_per_s_ + kBeta * residual / std::max(dt_s, 1e-3),
                              -kMostRatePerS, kMostRatePerS);
  }
  time_s_ = time_s;
  ++num_readings_;
}

breathing::Breath BeltFollower::At(double time_s) const noexcept {
  const double age_s = std::max(0.0, time_s - time_s_);
  const double slowing_s = std::clamp(age_s - kPredictS, 0.0, kSlowS);
  const double going_s =
      std::min(age_s, kPredictS) + slowing_s - 0.5 * slowing_s * slowing_s / kSlowS;
  const double speed = 1.0 - slowing_s / kSlowS;
  breathing::Breath breath;
  breath.level = std::clamp(level_ + level_per_s_ * going_s, -kMostLevel, kMostLevel);
  breath.level_per_s = level_per_s_ * speed;
  breath.cycle = CycleOf(breath.level, level_per_s_);
  return breath;
}

session::BreathStatus BeltFollower::StatusAt(double time_s) const noexcept {
  if (num_readings_ == 0) return session::BreathStatus::kLost;
  const double age_s = time_s - time_s_;
  if (age_s <= kFreshS) return session::BreathStatus::kBreathing;
  return age_s < kPredictS + kSlowS ? session::BreathStatus::kPredicted
                                    : session::BreathStatus::kLost;
}

double CycleOf(double level, double level_per_s) noexcept {
  const double half = std::acos(2.0 * std::clamp(level, 0.0, 1.0) - 1.0) / (2.0 * std::numbers::pi);
  return level_per_s <= 0.0 || half == 0.0 ? half : 1.0 - half;
}

}  // namespace acus::live
