// What is wrong with a recording: gaps, jumps, samples that the tracker did not see.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "acus/data/session/session.h"

namespace acus::session {

struct IntegrityLimits {
  double gap_s = 0.020;            ///< > 0. A longer pause is a gap ...
  double gap_intervals = 2.5;      ///< >= 1. ... if it is also this many median intervals long.
  double jump_mm = 50.0;           ///< > 0. Between neighbours, however far apart in time.
  double speed_mm_per_s = 5000.0;  ///< > 0. A hand does not move faster.
  /// > 0. Shorter moves are jitter, whatever speed they come to at 1 kHz.
  double jitter_mm = 2.0;
};

/// A place in a stream, with how much: seconds of a gap, mm of a jump, samples of an invalid run.
struct IntegrityEvent {
  std::int64_t time_ns = 0;  ///< Where it begins.
  std::size_t sample = 0;  ///< Index of the sample before it (of the first one of an invalid run).
  double amount = 0.0;
};

struct IntegrityReport {
  std::size_t num_samples = 0;
  std::size_t num_invalid = 0;
  double duration_s = 0.0;
  double median_interval_s = 0.0;  ///< 0 for a single sample. The rate is its inverse.
  double longest_interval_s = 0.0;
  std::size_t num_repeated =
      0;  ///< Samples with the time stamp of the one before, or an earlier one.
  std::size_t num_frozen = 0;   ///< Valid samples whose pose equals the one before in every bit.
  double extent_mm = 0.0;       ///< Of the valid positions, along the axis where it is largest.
  double median_step_mm = 0.0;  ///< Between neighbours that differ.
  double farthest_mm = 0.0;     ///< Largest coordinate of the valid positions.
  std::vector<IntegrityEvent> gaps;
  std::vector<IntegrityEvent> jumps;
  std::vector<IntegrityEvent> invalid_runs;

  bool clean() const {
    return num_repeated == 0 && gaps.empty() && jumps.empty() && num_invalid == 0;
  }
};

/// Looks through a stream, in any state. @throws InputError if a limit is out of its range.
/// @param commands  Of the session, in order of time: where hands are swapped, a tool does not
/// jump.
IntegrityReport CheckIntegrity(const PoseStream& stream, const IntegrityLimits& limits = {},
                               std::span<const Command> commands = {});

/// One sentence per kind of trouble, with the number of cases and the worst one: for warnings.
/// @param tool  "needle", "probe".
std::vector<std::string> Describe(const IntegrityReport& report, const std::string& tool);

}  // namespace acus::session
