// How another clock stands to ours, from the stamps and arrivals of its messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace acus::tracking {

/// Offset and drift of a source's clock, one way: messages only travel towards us.
///
/// A message stamped s arrives at a = s + offset + delay with delay >= the shortest one. The
/// smallest a - s of each second lies close to offset + shortest delay, whatever the jitter; a
/// straight line under the last 30 of them gives offset and drift (docs/concepts/tracking.md). The
/// shortest delay itself cannot be distinguished from the offset, so it is part of it.
///
/// A clock that is set (more than 0.5 s off the line) starts the estimate again. Allocates nothing.
class ClockEstimate {
 public:
  /// Takes the stamp of a message and its arrival, in order of arrival. ns.
  void Observe(std::int64_t source_ns, std::int64_t arrival_ns) noexcept;

  bool known() const noexcept { return known_; }
  /// Ours minus the source's at a time of ours. @pre known()
  std::int64_t OffsetNs(std::int64_t time_ns) const noexcept;
  /// The instant of a stamp in our clock, not after its arrival. @pre known()
  std::int64_t OursNs(std::int64_t source_ns, std::int64_t arrival_ns) const noexcept;
  double drift_ppm() const noexcept { return 1e6 * drift_; }
  int times_set() const noexcept { return times_set_; }

 private:
  static constexpr std::int64_t kWindowNs = 1'000'000'000;
  static constexpr std::int64_t kSetNs = 500'000'000;
  static constexpr std::size_t kWindows = 30;

  void Restart(std::int64_t offset_ns, std::int64_t arrival_ns) noexcept;
  void CloseWindow() noexcept;

  bool known_ = false;
  int times_set_ = 0;
  double drift_ = 0.0;             ///< ns per ns.
  std::int64_t base_time_ns_ = 0;  ///< offset = base_offset + drift (time - base_time).
  std::int64_t base_offset_ns_ = 0;
  std::int64_t window_start_ns_ = 0;
  std::int64_t smallest_ns_ = 0;  ///< Of this window, and when it was.
  std::int64_t smallest_time_ns_ = 0;
  struct Minimum {
    std::int64_t time_ns, offset_ns;
  };
  std::array<Minimum, kWindows> minima_ = {};
  std::size_t num_minima_ = 0;  ///< All that ever were since the start.
};

}  // namespace acus::tracking
