// A haptic device: reads a handle's pose at about 1 kHz and pushes the hand that holds it.
//
// Every force goes through a ForceGuard on its way to the motors, whatever the driver. A second
// thread of this class watches over the servo: it sends zero force if a tick does not come back,
// and opens the device again after an error of communication.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acus/rig/haptics/device_reading.h"
#include "acus/rig/haptics/force_guard.h"

namespace acus::haptics {

class Driver;

struct DeviceInfo {
  std::string name;                  ///< Model and serial number, for messages.
  double max_force_n = 0.0;          ///< 0: no motors.
  double max_torque_nmm = 0.0;       ///< 0: does not turn the hand.
  double rate_hz = 1000.0;           ///< Nominal.
  Eigen::AlignedBox3d workspace_mm;  ///< Device frame; empty if unknown.
  std::vector<std::string> notices;  ///< Plain words: what is worse than it might be, and the cure.
};

enum class DeviceState {
  kStopped,
  kRunning,
  kRecovering,  ///< Zero force; the device is being opened again.
  kFailed,      ///< Zero force; given up. `text` says why.
};

struct DeviceStatus {
  DeviceState state = DeviceState::kStopped;
  std::string text;                  ///< The last fault in plain words, and what to do; or empty.
  std::vector<std::string> notices;  ///< Since the start: no real-time priority, for one.
  std::int64_t ticks = 0;
  std::int64_t num_warnings = 0;  ///< Errors of the driver that it runs on after: warm motors.
  std::int64_t num_reopened = 0;
  std::int64_t num_overruns = 0;  ///< Ticks that the watchdog cut off.
  double longest_tick_ms = 0.0;   ///< Time in the servo.
  GuardCounts guard;
  DeviceReading reading;  ///< The newest, as the servo got it.
  DeviceForce force;      ///< The newest, as the motors got it.
};

/// Why forces are held at zero from outside; each reason is set and cleared by itself.
enum class Inhibit : unsigned { kTrackerLost = 1, kPaused = 2, kUser = 4 };

class HapticDevice {
 public:
  /// Opens the device, motors off. The guard's limits are the lower of `settings` and the device's.
  /// @throws InputError in plain words: what is missing, and what to try.
  HapticDevice(std::unique_ptr<Driver> driver, const GuardSettings& settings);
  ~HapticDevice();  ///< Stops.
  HapticDevice(const HapticDevice&) = delete;
  HapticDevice& operator=(const HapticDevice&) = delete;

  const DeviceInfo& info() const noexcept;

  /// Starts the servo. A device that was stopped or parked may be started again; counts and texts
  /// of status() begin again.
  /// @throws InputError if it cannot be, or runs.
  void Start(Servo servo);

  /// Zero force from the next reading on. The device stays open, and an error of communication is
  /// repaired as ever, until Start() gives it another servo. When it returns, no tick is under way,
  /// and the servo will not be called any more. Nothing happens if the device is not running.
  void Park() noexcept;

  /// Zero force, then the scheduler, then the device; the threads are joined. A second call has no
  /// effect.
  void Stop() noexcept;

  DeviceStatus status() const;  ///< Any thread.

  /// Any thread; takes effect at the next tick, with ramp-in when the last reason is cleared.
  void SetInhibited(Inhibit reason, bool on) noexcept;
  /// Any thread. To be repeated while the pedal is down: it counts as up 0.3 s after the last call.
  void HoldPedal() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace acus::haptics
