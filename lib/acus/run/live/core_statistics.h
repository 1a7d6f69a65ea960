// Performance counters of a live session: written by the real-time thread, read by any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "acus/run/live/duration_histogram.h"
#include "acus/run/live/pose_gate.h"

namespace acus::live {

struct CoreStatistics {
  using Count = std::atomic<std::int64_t>;
  static constexpr std::size_t kNumVerdicts = static_cast<std::size_t>(PoseVerdict::kJumped) + 1;

  Count ticks{0};
  Count steps{0};
  Count time_back{0};  ///< Readings not later than the one before: no step.
  /// Ticks whose CPU time exceeded the device's period: the models are too slow.
  Count missed_by_computation{0};
  /// Readings that are missing between two of the device: the machine was busy with another
  /// process, or the device is at fault.
  Count missed_by_machine{0};
  std::array<Count, kNumVerdicts> needle{};  ///< Number of steps by PoseVerdict.
  std::array<Count, kNumVerdicts> probe{};
  /// RMS of the needle's force above 30 Hz while the force is not zero, before the guard, N.
  std::atomic<double> needle_chatter_n{0.0};
  DurationHistogram step_cpu;         ///< CPU time of a tick.
  DurationHistogram device_to_force;  ///< From the reading to the force that answers it.
  DurationHistogram interval;         ///< From one reading to the next.

  nlohmann::json ToJson() const;
};

}  // namespace acus::live
