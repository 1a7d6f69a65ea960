// What a driver does for a HapticDevice. Implement it to add a device, with motors or without.
#pragma once

#include <cstdint>
#include <string>

#include "acus/rig/haptics/device_reading.h"
#include "acus/rig/haptics/haptic_device.h"

namespace acus::haptics {

/// What went wrong in a servo thread.
enum class DriverFault : std::uint8_t {
  kNone,
  kWarning,  ///< Runs on.
  kReopen,   ///< Communication: halt, open again, ramp-in.
  kFatal,    ///< Halt for good.
};

/// The guarded way from a reading to the force of the motors. The only way: a driver is given no
/// Servo. Called from one thread at a time. Never allocates, waits or throws.
class GuardedServo {
 public:
  virtual ~GuardedServo() = default;

  /// What the motors get for this reading. `clock` gives the time when the servo is done; null, for
  /// devices that are stepped, takes the reading's.
  virtual DeviceForce Tick(const DeviceReading& reading,
                           std::int64_t (*clock)() noexcept) noexcept = 0;

  /// Reports an error of the vendor's library by its number; Driver::FaultText() words it.
  virtual void Report(DriverFault fault, int code) noexcept = 0;

  /// A message for the user, in plain words. From Run() only, not from a servo thread.
  virtual void Notice(const std::string& text) = 0;
};

class Driver {
 public:
  virtual ~Driver() = default;

  /// Finds and prepares the device, motors off. Called again after Halt() to open it again.
  /// @throws InputError
  virtual DeviceInfo Open() = 0;

  /// Starts the servo thread (its own, or the vendor's), which calls `servo` until Halt().
  /// @throws InputError, after which the device is as after Halt().
  virtual void Run(GuardedServo& servo) = 0;

  /// Zero force, stop the scheduler, disable the device, in this order; continues if one fails.
  /// When it returns, the servo is not called any more. Also after a failed Open() or Run(), and
  /// twice.
  virtual void Halt() noexcept = 0;

  /// Zero force right now, from any thread, while the servo thread may be stuck. Must not block
  /// for long, and need not be remembered: Tick() gives zero from now on.
  virtual void ZeroNow() noexcept = 0;

  /// True for a device that has no thread and is stepped by its owner: nothing watches its time.
  virtual bool IsStepped() const { return false; }

  /// What `code` of GuardedServo::Report means and what to do about it. Any thread.
  virtual std::string FaultText(int code) const = 0;
};

}  // namespace acus::haptics
