// The last thing that every force passes before a motor: nothing leaves it that is not finite, not
// within the limits, or grows faster than it may. docs/concepts/haptic_devices.md.
//
// Pure: the time comes from its inputs only, so that the same inputs give the same bits. One
// thread calls Admit() and Limit() in turns; any thread reads the counts.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "acus/rig/haptics/device_reading.h"

namespace acus::haptics {

enum class DeadMan {
  kNone,
  kButton,  ///< A button of the device: `dead_man_buttons`.
  kPedal,   ///< Something else, given by GuardConditions::pedal_held.
};

struct GuardSettings {
  double max_force_n = 3.0;
  double max_torque_nmm = 100.0;
  /// RMS force that the motors bear for ever; 0: as much as max_force_n.
  double continuous_force_n = 0.0;
  double continuous_over_s = 30.0;  ///< Time constant of the mean of the squared force.
  double force_slew_n_per_s = 500.0;
  double torque_slew_nmm_per_s = 20000.0;
  double ramp_in_s = 0.5;  ///< From nothing to the whole force, after a start and after a fault.
  double settle_s = 0.05;  ///< Readings must be good for so long before the ramp begins.
  double late_s = 0.01;    ///< Later than this after the one before, or after its reading: fault.
  double jump_mm = 20.0;   ///< Farther than this from one reading to the next: fault.
  double jump_rad = 0.785;
  DeadMan dead_man = DeadMan::kNone;
  unsigned dead_man_buttons = 1;  ///< Bits; any of them.

  /// @throws InputError naming the value that is not finite or out of range; `label` begins it.
  void Check(const char* label) const;
};

/// What the guard did. Those before kForceMagnitude are faults: force zero, then ramp-in.
enum class GuardAct : std::uint8_t {
  kReadingInvalid,    ///< The device said so.
  kReadingNotFinite,  ///< A pose or velocity that is not finite, or no rotation.
  kReadingJumped,
  kTimeBack,     ///< A reading not later than the one before.
  kReadingLate,  ///< The servo was called late.
  kStepLate,     ///< The servo took too long.
  kForceNotFinite,
  kDeadManOpen,  ///< Or its button has never been seen open since the start.
  kMotorsOff,    ///< DeviceReading::motors_on.
  kInhibited,    ///< By GuardConditions::inhibited: the tracker is lost, for one.
  kForceMagnitude,
  kTorqueMagnitude,
  kForceContinuous,  ///< By continuous_force_n.
  kForceSlew,
  kTorqueSlew,
  kRampIn,
};
inline constexpr std::size_t kNumGuardActs = static_cast<std::size_t>(GuardAct::kRampIn) + 1;

/// In plain words: "the reading jumped".
const char* Words(GuardAct act) noexcept;

/// Number of ticks with each act since the guard was made.
struct GuardCounts {
  std::array<std::int64_t, kNumGuardActs> of{};
  std::int64_t ticks = 0;
  unsigned now = 0;  ///< Acts of the last tick: bit i for GuardAct i.

  std::int64_t operator[](GuardAct act) const { return of[static_cast<std::size_t>(act)]; }
  bool IsActing(GuardAct act) const { return (now >> static_cast<unsigned>(act) & 1U) != 0; }
};

/// What others have to say about a tick.
struct GuardConditions {
  bool inhibited = false;
  bool pedal_held = false;
};

class ForceGuard {
 public:
  /// @pre settings.Check() passes.
  explicit ForceGuard(const GuardSettings& settings) noexcept : settings_(settings) {}

  /// Begins again: no force, ramp-in, dead-man to be seen open. The counts stay.
  void Restart() noexcept;

  /// Judges a reading. What comes back is finite and rigid, and valid only if no fault is pending.
  DeviceReading Admit(const DeviceReading& reading, const GuardConditions& conditions) noexcept;

  /// What the motors may get for the reading that was just admitted. For the output f of this and
  /// g of the last tick, dt apart (late_s at most), and limits F and S:
  ///   f is finite, |f| <= F, |f| <= |g| + S dt, and f lies within S dt of some point of [0, g];
  /// so a force may vanish at once, but not appear or turn at once. With a continuous limit C, the
  /// exponential mean of |f|^2 never exceeds C^2; the restart of the guard does not cool the
  /// motors.
  /// @param now_ns  when the servo was done; same clock as the reading's.
  DeviceForce Limit(const DeviceForce& wanted, std::int64_t now_ns) noexcept;

  /// The reading that was just admitted is not later than the one before.
  bool TimeWentBack() const noexcept {
    return (acts_ >> static_cast<unsigned>(GuardAct::kTimeBack) & 1U) != 0;
  }
  GuardCounts counts() const noexcept;
  const GuardSettings& settings() const noexcept { return settings_; }

 private:
  void JudgeTime(std::int64_t time_ns) noexcept;
  bool JudgeReading(const DeviceReading& reading) noexcept;
  void JudgeConditions(const DeviceReading& reading, const GuardConditions& conditions) noexcept;
  double RampShare() const noexcept;
  double WarmingShare() const noexcept;
  double ContinuousLimitN() const noexcept;
  void Warm() noexcept;
  void Note(GuardAct act) noexcept;
  void Publish() noexcept;

  GuardSettings settings_;
  unsigned acts_ = 0;  ///< Of this tick.

  bool has_seen_ = false;
  std::int64_t seen_ns_ = 0;   ///< Of the newest reading, good or not.
  double since_last_s_ = 0.0;  ///< From the reading before; 0 to late_s.
  bool has_before_ = false;
  DeviceReading before_;  ///< The last pose, whether it had jumped or not.
  DeviceReading last_good_;
  bool readings_are_steady_ = false;
  std::int64_t readings_steady_since_ns_ = 0;
  bool was_settled_ = false;
  bool is_steady_ = false;  ///< No fault of any kind.
  std::int64_t steady_since_ns_ = 0;
  bool dead_man_was_open_ = false;
  DeviceForce output_;
  double mean_square_n2_ = 0.0;  ///< Of the force that the motors got.

  std::array<std::atomic<std::int64_t>, kNumGuardActs> counts_{};
  std::atomic<std::int64_t> ticks_{0};
  std::atomic<unsigned> now_{0};
};

}  // namespace acus::haptics
