#include "acus/rig/haptics/force_guard.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::haptics {
namespace {

constexpr double kRotationTolerance = 1e-3;
/// Share of the continuous limit: up to this mean square, in shares of its own, the peak limit
/// holds alone.
constexpr double kCool = 0.64;
constexpr double kAboutOne = 1.0 - 1e-15;  ///< So that rounding never goes over a limit.

/// From `a` to `b`, for any two numbers.
double SecondsBetween(std::int64_t a_ns, std::int64_t b_ns) {
  std::int64_t difference_ns = 0;
  if (__builtin_sub_overflow(b_ns, a_ns, &difference_ns)) return b_ns > a_ns ? 1e10 : -1e10;
  return 1e-9 * static_cast<double>(difference_ns);
}

bool IsFiniteAndRigid(const DeviceReading& reading) {
  if (!reading.device_from_handle.matrix().allFinite() || !reading.velocity_mm_s.allFinite() ||
      !reading.angular_velocity_rad_s.allFinite()) {
    return false;
  }
  const Eigen::Matrix3d r = reading.device_from_handle.linear();
  const Eigen::Matrix3d error = r.transpose() * r - Eigen::Matrix3d::Identity();
  return error.cwiseAbs().maxCoeff() <= kRotationTolerance && r.determinant() > 0.0;
}

bool IsFarFrom(const DeviceReading& a, const DeviceReading& b, const GuardSettings& settings) {
  const double travel_mm =
      (a.device_from_handle.translation() - b.device_from_handle.translation()).stableNorm();
  const double trace =
      (a.device_from_handle.linear().transpose() * b.device_from_handle.linear()).trace();
  return !(travel_mm <= settings.jump_mm && trace >= 1.0 + 2.0 * std::cos(settings.jump_rad));
}

/// Shortens to `most`; true if it had to.
bool Shorten(Eigen::Vector3d& vector, double most) {
  const double length = vector.stableNorm();
  if (length <= most) return false;
  // Twice, since what is too long by far is not scaled exactly.
  vector *= most / length * kAboutOne;
  const double left = vector.stableNorm();
  if (left > most) vector *= most / left * kAboutOne;
  return true;
}

/// Brings `wanted` to within `step` of the span from nothing to `last`; true if it had to.
bool Slow(Eigen::Vector3d& wanted, const Eigen::Vector3d& last, double step) {
  const double squared = last.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(wanted.dot(last) / squared, 0.0, 1.0) : 0.0;
  const Eigen::Vector3d nearest = share * last;
  Eigen::Vector3d change = wanted - nearest;
  if (!Shorten(change, step)) return false;
  wanted = nearest + change;
  return true;
}

void RequireWithin(const char* label, const char* key, double value, double low, double high) {
  ACUS_REQUIRE(value >= low && value <= high, label, ": ", key, " is ", value, "; it must lie in [",
               low, ", ", high, "]");
}

}  // namespace

const char* Words(GuardAct act) noexcept {
  switch (act) {
    case GuardAct::kReadingInvalid:
      return "the device gave no reading";
    case GuardAct::kReadingNotFinite:
      return "the reading was not a pose";
    case GuardAct::kReadingJumped:
      return "the reading jumped";
    case GuardAct::kTimeBack:
      return "the time of a reading did not advance";
    case GuardAct::kReadingLate:
      return "the device was read late";
    case GuardAct::kStepLate:
      return "the computation was late";
    case GuardAct::kForceNotFinite:
      return "the computed force was not a number";
    case GuardAct::kDeadManOpen:
      return "the dead-man switch is open";
    case GuardAct::kMotorsOff:
      return "the device has its motors switched off";
    case GuardAct::kInhibited:
      return "forces are held at zero";
    case GuardAct::kForceMagnitude:
      return "the force was cut to its limit";
    case GuardAct::kTorqueMagnitude:
      return "the torque was cut to its limit";
    case GuardAct::kForceContinuous:
      return "the force was cut as the motors were warm";
    case GuardAct::kForceSlew:
      return "the force grew too fast and was slowed";
    case GuardAct::kTorqueSlew:
      return "the torque grew too fast and was slowed";
    case GuardAct::kRampIn:
      return "forces are being ramped in";
  }
  return "";
}

void GuardSettings::Check(const char* label) const {
  RequireWithin(label, "max_force_n", max_force_n, 0.0, 40.0);
  RequireWithin(label, "max_torque_nmm", max_torque_nmm, 0.0, 5000.0);
  RequireWithin(label, "continuous_force_n", continuous_force_n, 0.0, 40.0);
  RequireWithin(label, "continuous_over_s", continuous_over_s, 1.0, 3600.0);
  RequireWithin(label, "force_slew_n_per_s", force_slew_n_per_s, 1.0, 1e5);
  RequireWithin(label, "torque_slew_nmm_per_s", torque_slew_nmm_per_s, 1.0, 1e7);
  RequireWithin(label, "ramp_in_s", ramp_in_s, 0.0, 10.0);
  RequireWithin(label, "settle_s", settle_s, 0.0, 10.0);
  RequireWithin(label, "late_s", late_s, 0.0005, 0.2);
  RequireWithin(label, "jump_mm", jump_mm, 0.1, 1000.0);
  RequireWithin(label, "jump_rad", jump_rad, 0.01, 3.0);
  ACUS_REQUIRE(dead_man != DeadMan::kButton || dead_man_buttons != 0, label,
               ": a dead-man button is required, but no button is named");
}

void ForceGuard::Note(GuardAct act) noexcept {
  acts_ |= 1U << static_cast<unsigned>(act);
}

void ForceGuard::Restart() noexcept {
  is_steady_ = false;
  readings_are_steady_ = false;
  has_before_ = false;
  has_seen_ = false;
  dead_man_was_open_ = false;
  output_ = DeviceForce();
}

bool ForceGuard::JudgeReading(const DeviceReading& reading) noexcept {
  if (!reading.valid) {
    Note(GuardAct::kReadingInvalid);
    return false;
  }
  if (!IsFiniteAndRigid(reading)) {
    Note(GuardAct::kReadingNotFinite);
    return false;
  }
  const bool jumped = has_before_ && IsFarFrom(before_, reading, settings_);
  before_ = reading;
  has_before_ = true;
  if (jumped) Note(GuardAct::kReadingJumped);
  return !jumped;
}

void ForceGuard::JudgeTime(std::int64_t time_ns) noexcept {
  since_last_s_ = has_seen_ ? SecondsBetween(seen_ns_, time_ns) : 0.0;
  if (has_seen_ && since_last_s_ <= 0.0) Note(GuardAct::kTimeBack);
  if (since_last_s_ > settings_.late_s) Note(GuardAct::kReadingLate);
  since_last_s_ = std::clamp(since_last_s_, 0.0, settings_.late_s);
  seen_ns_ = time_ns;
  has_seen_ = true;
}

void ForceGuard::JudgeConditions(const DeviceReading& reading,
                                 const GuardConditions& conditions) noexcept {
  if (reading.valid && !reading.motors_on) Note(GuardAct::kMotorsOff);
  if (conditions.inhibited) Note(GuardAct::kInhibited);
  if (settings_.dead_man == DeadMan::kNone) return;
  const bool is_held = settings_.dead_man == DeadMan::kPedal
                           ? conditions.pedal_held
                           : (reading.buttons & settings_.dead_man_buttons) != 0;
  // A switch that is stuck is no switch: it must have been open once.
  dead_man_was_open_ = dead_man_was_open_ || !is_held;
  if (!is_held || !dead_man_was_open_) Note(GuardAct::kDeadManOpen);
}

DeviceReading ForceGuard::Admit(const DeviceReading& reading,
                                const GuardConditions& conditions) noexcept {
  acts_ = 0;
  JudgeTime(reading.time_ns);
  const bool reading_is_good = JudgeReading(reading);
  JudgeConditions(reading, conditions);
  const bool is_good = acts_ == 0;
  if (is_good && !is_steady_) steady_since_ns_ = reading.time_ns;
  is_steady_ = is_good;
  if (reading_is_good && !readings_are_steady_) readings_steady_since_ns_ = reading.time_ns;
  // The very first readings are taken at once: there is nothing that they could have jumped from.
  const bool is_first = reading_is_good && !last_good_.valid;
  readings_are_steady_ = reading_is_good;
  const bool is_settled =
      is_first || (was_settled_ && reading_is_good) ||
      (reading_is_good &&
       SecondsBetween(readings_steady_since_ns_, reading.time_ns) >= settings_.settle_s);
  was_settled_ = is_settled;
  if (is_settled) {
    last_good_ = reading;
    return reading;
  }
  DeviceReading held = last_good_;
  held.time_ns = reading.time_ns;
  held.buttons = reading.valid ? reading.buttons : 0;
  held.velocity_mm_s.setZero();
  held.angular_velocity_rad_s.setZero();
  held.valid = false;
  return held;
}

double ForceGuard::RampShare() const noexcept {
  const double steady_s = SecondsBetween(steady_since_ns_, seen_ns_) - settings_.settle_s;
  if (steady_s < 0.0) return 0.0;
  return steady_s >= settings_.ramp_in_s ? 1.0 : steady_s / settings_.ramp_in_s;
}

/// Weight of the new force on average of the squares.
double ForceGuard::WarmingShare() const noexcept {
  return -std::expm1(-since_last_s_ / settings_.continuous_over_s);
}

/// From the peak, while the motors are cool, down to the continuous limit C as the mean square m
/// approaches C^2: linear in the square of the force.
double ForceGuard::ContinuousLimitN() const noexcept {
  const double peak = settings_.max_force_n;
  const double limit = settings_.continuous_force_n;
  if (limit <= 0.0 || limit >= peak) return peak;
  const double square = limit * limit;
  const double warm = (mean_square_n2_ / square - kCool) / (1.0 - kCool);
  const double by_warmth = peak * peak - std::clamp(warm, 0.0, 1.0) * (peak * peak - square);
  // Whatever the interval, the next mean is not above the limit.
  const double share = WarmingShare();
  const double by_mean =
      share > 0.0 ? mean_square_n2_ + (square - mean_square_n2_) / share : by_warmth;
  return std::sqrt(std::max(0.0, std::min(by_warmth, by_mean)));
}

void ForceGuard::Warm() noexcept {
  mean_square_n2_ += WarmingShare() * (output_.force_n.squaredNorm() - mean_square_n2_);
}

DeviceForce ForceGuard::Limit(const DeviceForce& wanted, std::int64_t now_ns) noexcept {
  if (SecondsBetween(seen_ns_, now_ns) > settings_.late_s) Note(GuardAct::kStepLate);
  if (!wanted.force_n.allFinite() || !wanted.torque_nmm.allFinite()) {
    Note(GuardAct::kForceNotFinite);
  }
  if (acts_ != 0) {  // So far, there are only faults.
    is_steady_ = false;
    output_ = DeviceForce();
    Warm();
    Publish();
    return output_;
  }
  DeviceForce force = wanted;
  if (Shorten(force.force_n, settings_.max_force_n)) Note(GuardAct::kForceMagnitude);
  if (Shorten(force.torque_nmm, settings_.max_torque_nmm)) Note(GuardAct::kTorqueMagnitude);
  const double continuous_n = ContinuousLimitN();
  if (Shorten(force.force_n, continuous_n)) Note(GuardAct::kForceContinuous);
  const double share = RampShare();
  if (share < 1.0 && !(force.force_n.isZero(0.0) && force.torque_nmm.isZero(0.0))) {
    Note(GuardAct::kRampIn);
  }
  force.force_n *= share;
  force.torque_nmm *= share;
  const double force_step_n = settings_.force_slew_n_per_s * since_last_s_;
  const double torque_step_nmm = settings_.torque_slew_nmm_per_s * since_last_s_;
  if (Slow(force.force_n, output_.force_n, force_step_n)) Note(GuardAct::kForceSlew);
  if (Slow(force.torque_nmm, output_.torque_nmm, torque_step_nmm)) Note(GuardAct::kTorqueSlew);
  // The sum above was rounded.
  Shorten(force.force_n, std::min(settings_.max_force_n, continuous_n));
  Shorten(force.torque_nmm, settings_.max_torque_nmm);
  output_ = force;
  Warm();
  Publish();
  return output_;
}

void ForceGuard::Publish() noexcept {
  // Only this thread writes: no need for an atomic addition.
  for (std::size_t i = 0; i < kNumGuardActs; ++i) {
    if ((acts_ >> i & 1U) == 0) continue;
    counts_[i].store(counts_[i].load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  now_.store(acts_, std::memory_order_relaxed);
}

GuardCounts ForceGuard::counts() const noexcept {
  GuardCounts counts;
  for (std::size_t i = 0; i < kNumGuardActs; ++i) {
    counts.of[i] = counts_[i].load(std::memory_order_relaxed);
  }
  counts.ticks = ticks_.load(std::memory_order_relaxed);
  counts.now = now_.load(std::memory_order_relaxed);
  return counts;
}

}  // namespace acus::haptics
