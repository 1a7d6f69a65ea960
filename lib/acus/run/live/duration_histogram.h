// A histogram of durations: percentiles of many values without storing them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace acus::live {

/// Counts durations in bins of 9 % width, from 0.1 us to 100 s. One thread adds, any thread reads.
/// Adding takes a few nanoseconds, allocates nothing and never waits.
class DurationHistogram {
 public:
  static constexpr int kBinsPerOctave = 8;
  static constexpr int kNumBins = 30 * kBinsPerOctave;
  static constexpr double kSmallestNs = 100.0;

  /// Durations below the range count in the first bin, those above it in the last.
  void Add(std::int64_t duration_ns) noexcept;

  std::int64_t count() const noexcept;
  std::int64_t max_ns() const noexcept { return max_ns_.load(std::memory_order_relaxed); }
  /// The upper edge of the bin that holds this share of all values, never above the largest one;
  /// 0 if there are none. @pre 0 <= share <= 1.
  double QuantileNs(double share) const noexcept;

  /// {"count", "median_ms", "p99_ms", "p99_9_ms", "max_ms"}.
  nlohmann::json ToJson() const;

 private:
  std::array<std::atomic<std::int64_t>, kNumBins> bins_{};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace acus::live
