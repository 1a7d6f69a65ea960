// Anything that tracks tools: a tracker over the network, a camera, a script.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acus/rig/tracking/pose_board.h"

namespace acus::tracking {

enum class SourceState {
  kStopped,     ///< Not started, or stopped.
  kConnecting,  ///< Looking for the peer or device; tries again by itself.
  kConnected,   ///< Linked.
};

/// "stopped", "connecting", "connected".
const char* Name(SourceState state);

/// What came and what became of it: nothing is dropped without being counted here.
struct SourceCounts {
  std::uint64_t messages = 0;        ///< Whole and right messages (or camera images).
  std::uint64_t readings = 0;        ///< Readings of our tools; all of them were published.
  std::uint64_t not_seen = 0;        ///< Of these: the source says that the tool is not in view.
  std::uint64_t bad_poses = 0;       ///< Of these: NaN, or not rigid; published as not valid.
  std::uint64_t out_of_order = 0;    ///< Of these: stamp before the last one.
  std::uint64_t repeated = 0;        ///< Of these: stamp equal to the last one.
  std::uint64_t fell_silent = 0;     ///< Published as not valid because nothing came for too long.
  std::uint64_t other_tools = 0;     ///< Readings of tools that were not requested.
  std::uint64_t other_messages = 0;  ///< Of a type that is not ours.
  std::uint64_t bad_messages = 0;    ///< Checksum, size or content wrong.
  std::uint64_t skipped_bytes = 0;   ///< Thrown away in search of the next message.
  std::uint64_t connects = 0;        ///< Links that came about; all but the first are reconnects.
  std::uint64_t lost_from_journal = 0;

  /// What was counted after `before` was.
  SourceCounts Since(const SourceCounts& before) const;
};

/// How the source's clock stands to ours.
struct ClockStatus {
  bool known = false;
  std::int64_t offset_ns = 0;      ///< Ours minus the source's, at the last reading.
  double drift_ppm = 0.0;          ///< Rate of the offset: positive if the source's clock is slow.
  int times_set = 0;               ///< How often the source's clock was set meanwhile.
  std::int64_t last_delay_ns = 0;  ///< Of the last reading, beyond the shortest.
  std::int64_t max_delay_ns = 0;   ///< Largest since the link came about.
};

struct SourceStatus {
  SourceState state = SourceState::kStopped;
  std::string last_error = {};    ///< In plain words; stays after it is repaired. Empty if none.
  std::string peer_status = {};   ///< What the peer last said about itself (STATUS). May be empty.
  std::int64_t last_news_ns = 0;  ///< Arrival of the last message, MonotonicNs(). 0 if none.
  SourceCounts counts = {};
  ClockStatus clock = {};
  /// Names that came and were not requested (the first few): what to write into the config.
  std::vector<std::string> other_names = {};
  /// For each tool why it is not seen, as far as its messages show it; empty where it is, or is not
  /// known. May be shorter than the tools.
  std::vector<std::string> why_not_seen = {};
};

/// A source runs by itself once started. Poses are read from its board.
class PoseSource {
 public:
  virtual ~PoseSource() = default;  ///< Stops.

  virtual std::string name() const = 0;
  /// Starts the thread(s) of the source and returns at once; a peer that is not there yet is no
  /// error. @throws InputError if it can never work (no such device, address not understood).
  virtual void Start() = 0;
  /// Ends its threads, within about 100 ms. Idempotent.
  virtual void Stop() noexcept = 0;

  /// Poses, from any thread. Lives as long as the source.
  virtual PoseBoard& board() noexcept = 0;
  /// For screens and logs: takes a lock and allocates, so not from the loop that feels forces.
  virtual SourceStatus status() const = 0;
};

}  // namespace acus::tracking
