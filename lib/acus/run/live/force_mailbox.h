// The force for a device whose own servo does not run the steps.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "acus/rig/haptics/device_reading.h"

namespace acus::live {

/// One thread puts, any number read; nobody waits. A reader that meets a write reads again, at most
/// a few times, and then takes no force.
class ForceMailbox {
 public:
  void Put(const haptics::DeviceForce& force, std::int64_t time_ns) noexcept {
    const std::uint64_t number = number_.load(std::memory_order_relaxed);
    number_.store(number + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < 3; ++i) {
      values_[i].store(force.force_n[static_cast<int>(i)], std::memory_order_relaxed);
      values_[i + 3].store(force.torque_nmm[static_cast<int>(i)], std::memory_order_relaxed);
    }
    time_ns_.store(time_ns, std::memory_order_relaxed);
    number_.store(number + 2, std::memory_order_release);
  }

  /// The last force; none if it is older than `oldest_ns`.
  haptics::DeviceForce Get(std::int64_t now_ns, std::int64_t oldest_ns) const noexcept {
    for (int attempt = 0; attempt < 8; ++attempt) {
      const std::uint64_t before = number_.load(std::memory_order_acquire);
      haptics::DeviceForce force;
      for (std::size_t i = 0; i < 3; ++i) {
        force.force_n[static_cast<int>(i)] = values_[i].load(std::memory_order_relaxed);
        force.torque_nmm[static_cast<int>(i)] = values_[i + 3].load(std::memory_order_relaxed);
      }
      const std::int64_t time_ns = time_ns_.load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if (before % 2 != 0 || number_.load(std::memory_order_relaxed) != before) continue;
      return before == 0 || now_ns - time_ns > oldest_ns ? haptics::DeviceForce{} : force;
    }
    return {};
  }

 private:
  std::atomic<std::uint64_t> number_{0};  ///< Odd while a force is being put.
  std::array<std::atomic<double>, 6> values_{};
  std::atomic<std::int64_t> time_ns_{0};
};

}  // namespace acus::live
