// The door between a vendor's thread and a driver that wants to stop.
#pragma once

#include <atomic>

namespace acus::haptics {

/// A vendor's scheduler calls back on a separate thread and cannot be joined. The gate lets its
/// calls through until one of them has been the last.
class CallbackGate {
 public:
  void Open() noexcept;
  void Shut() noexcept { has_ended_.store(true, std::memory_order_release); }

  /// Runs `tick` unless the gate is shut; shuts it if that returns false. Called by the vendor.
  /// @return whether there is to be another call.
  template <typename Tick>
  bool Pass(const Tick& tick) noexcept {
    is_inside_.store(true, std::memory_order_release);
    bool goes_on = false;
    if (!has_ended_.load(std::memory_order_acquire)) {
      goes_on = tick();
      if (!goes_on) Shut();
    }
    is_inside_.store(false, std::memory_order_release);
    return goes_on;
  }

  /// True once the tick that runs now must be the last: it sends zero, and returns false.
  bool is_last() const noexcept { return stopping_.load(std::memory_order_acquire); }

  /// Waits for a last tick, a fifth of a second at most, and shuts the gate.
  /// @return false if the vendor calls no more: the motors are as the tick before left them.
  bool AwaitLastTick() noexcept;

  /// Returns when no call is inside. @pre the vendor makes no more.
  void AwaitNobodyInside() const noexcept;

 private:
  std::atomic<bool> stopping_{false};
  std::atomic<bool> has_ended_{true};
  std::atomic<bool> is_inside_{false};
};

}  // namespace acus::haptics
