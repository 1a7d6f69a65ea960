// The latest pose of each tracked tool, lock-free to read from the loop that feels forces.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/transforms/pose.h"

namespace acus::tracking {

/// One reading of a tracked tool. Times in ns.
struct TrackedPose {
  std::int64_t time_ns = 0;         ///< Arrival, MonotonicNs(). 0: nothing came yet.
  std::int64_t source_time_ns = 0;  ///< The source's own stamp, in its own clock; 0 if it has none.
  /// When it was measured, in our clock: source stamp plus the estimated offset of the clocks (see
  /// clock_estimate.h), never after arrival. Arrival, if the source has no usable stamps.
  std::int64_t measured_ns = 0;
  transforms::Pose reference_from_tool = {};  ///< mm. The last good one while the tool is not seen.
  bool valid = false;                         ///< False: not seen, or the reading was not usable.
  std::uint64_t number = 0;  ///< Readings of this tool so far, this one included; shows gaps.

  /// Age of the news, not of the measurement. Nothing yet: the largest there is.
  std::int64_t AgeNs(std::int64_t now_ns) const noexcept {
    return number == 0 ? INT64_MAX : now_ns - time_ns;
  }
};

/// A reading with its tool, as the recorder takes it.
struct ToolReading {
  std::size_t tool = 0;
  TrackedPose pose = {};
};

/// Named tools and what was last heard of each. One thread writes (the source's), any number read.
///
/// Reading and writing take no lock, allocate nothing and do not throw. A reader never waits for a
/// writer that was interrupted; it reads again only if a whole new reading was published meanwhile.
/// Every reading also goes to the journal, from which one thread (the recorder) takes them all;
/// what does not fit is counted.
class PoseBoard {
 public:
  /// @param tools  Their names, each once.
  /// @param journal_capacity  Readings that the journal holds; 0 for no journal. The recorder takes
  ///     them every half second: 30 tools at 1 kHz need 15,000.
  /// @throws InputError if a name is empty or there twice.
  explicit PoseBoard(std::vector<std::string> tools, std::size_t journal_capacity = 0);
  ~PoseBoard();
  PoseBoard(const PoseBoard&) = delete;
  PoseBoard& operator=(const PoseBoard&) = delete;

  const std::vector<std::string>& tools() const noexcept { return tools_; }
  /// Look up once, at start. Nothing if there is no such tool.
  std::optional<std::size_t> Find(std::string_view tool) const noexcept;

  /// Any thread. @pre tool < tools().size()
  TrackedPose Latest(std::size_t tool) const noexcept;

  /// The writer. Sets `number`; for a reading that is not valid, the pose is the last good one.
  /// @pre a valid pose is finite and rigid.
  void Publish(std::size_t tool, TrackedPose reading) noexcept;

  /// The recorder: moves the oldest readings to `out`, returns how many.
  std::size_t TakeReadings(std::span<ToolReading> out) noexcept;
  /// Readings that found the journal full. They were published, but will not be recorded.
  std::uint64_t lost_from_journal() const noexcept;

 private:
  struct Slot;
  struct Journal;
  std::vector<std::string> tools_;
  std::unique_ptr<Slot[]> slots_;
  std::unique_ptr<Journal> journal_;
};

}  // namespace acus::tracking
