// Recordings of other programs as sessions: what acus-import does.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session_import.h"

namespace acus::session {

/// What is done with frames that are earlier than one before them.
enum class TimeGoingBack { kRefuse, kDrop, kCut };

struct RecordingOptions {
  ImportOptions frames = {};
  /// > 0: time stamps are made up at this rate for a recording in which a frame has none. 0: such a
  /// recording is an error.
  double frame_rate_hz = 0.0;
  std::filesystem::path columns = {};  ///< Of a CSV: a file of format acus-columns/1.
  /// Of a PLUS sequence: kDrop omits the frames that are late, kCut all from the first on.
  TimeGoingBack time_going_back = TimeGoingBack::kRefuse;
  bool as_it_is = false;  ///< Places that no tracker sees are not refused.
};

/// As ReadAnySession, and also CSV files of trackers.
/// @throws InputError, naming the option of acus-import that helps.
ImportedSession ImportRecording(const std::filesystem::path& path, const RecordingOptions& options,
                                const RunContext& context);

/// What is wrong with the times of needle and probe beside each other: their ranges if they have no
/// time in common, otherwise empty. Two clocks that were not set by each other give such streams.
/// ReadAnySession refuses them.
std::string WithoutCommonTime(const Session& session);

/// What was found for needle and probe: frame, samples, rate, duration, share that was seen,
/// troubles; and what is missing.
std::string ImportReport(const ImportedSession& imported);

}  // namespace acus::session
