// The virtual hand as a haptic device: at 1 kHz from a separate thread, or stepped by its owner.
#pragma once

#include <atomic>
#include <memory>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/real_time.h"
#include "acus/rig/haptics/virtual_hand.h"

namespace acus::haptics {

class VirtualHandDriver final : public Driver {
 public:
  enum class Clock {
    kOwnThread,  ///< At settings.rate_hz.
    kStepped,    ///< Step() only. Deterministic.
  };

  /// `steering` may be null.
  VirtualHandDriver(const VirtualHandSettings& settings, std::shared_ptr<HandSteering> steering,
                    Clock clock = Clock::kOwnThread);

  /// One tick of the servo at `time_ns`, which must increase. Does nothing before Run() and after
  /// Halt(). @pre the clock is kStepped.
  void Step(std::int64_t time_ns) noexcept;

  DeviceInfo Open() override;
  void Run(GuardedServo& servo) override;
  void Halt() noexcept override;
  void ZeroNow() noexcept override {}
  bool IsStepped() const override { return clock_ == Clock::kStepped; }
  std::string FaultText(int code) const override;

 private:
  void TickAt(std::int64_t time_ns, std::int64_t (*clock)() noexcept) noexcept;

  std::shared_ptr<HandSteering> steering_;
  Clock clock_;
  VirtualHand hand_;
  GuardedServo* servo_ = nullptr;
  std::int64_t last_ns_ = 0;
  bool has_ticked_ = false;
  DeviceForce force_;
  ServoThread thread_;
};

}  // namespace acus::haptics
