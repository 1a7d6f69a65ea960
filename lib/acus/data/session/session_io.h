// Our own session folder: session.json and one CSV per stream.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"

namespace acus::session {

/// Reads a session folder. docs/reference/formats_sessions.md describes it.
///
/// Strict: NaN, a time that does not increase, a quaternion whose norm is off by more than 1e-3, or
/// a status other than OK and INVALID is an error at file:row. A last line that is cut off (a crash
/// while recording) is dropped with a warning. INVALID samples take the last good pose before them
/// (the first good one, if there is none before); their numbers are not looked at. Raw readings of
/// trackers are not read.
/// @throws InputError
Session ReadSession(const std::filesystem::path& folder, const RunContext& context);

inline constexpr const char* kNeedleFile = "needle.csv";
inline constexpr const char* kProbeFile = "probe.csv";
inline constexpr const char* kBreathingFile = "breathing.csv";
inline constexpr const char* kCommandsFile = "commands.csv";
inline constexpr const char* kTrackerFile = "tracker.csv";

/// Which files a session has.
struct StreamNames {
  bool needle = false;
  bool probe = false;
  bool breathing = false;
  bool commands = false;
  bool tracker = false;  ///< Raw readings; nothing is computed from them.
};

/// What session.json says.
nlohmann::json SessionDescription(const StreamNames& streams, const std::string& name,
                                  const std::string& reference_frame);

/// Writes a session folder, atomically. Reading it back gives the same bits.
/// @throws InputError if the session has no stream, a time does not increase, a pose is not finite,
///     or the folder cannot be written (see AtomicFolder).
void WriteSession(const std::filesystem::path& folder, const Session& session,
                  const RunContext& context);

}  // namespace acus::session
