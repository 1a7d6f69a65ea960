// Sessions on disk: our own folder, PLUS sequence files and Slicer sequences.
#pragma once

#include <filesystem>

#include "core/run_context.h"
#include "session/session.h"

namespace acus::session {

/// Reads a session folder (session.json and one CSV per stream).
///
/// Strict: NaN, a time that does not increase, or a quaternion whose norm is off by more than 1e-3
/// is an error at file:row. A line that is cut off at the end of a stream (a crash while recording)
/// is dropped with a warning.
Session ReadSession(const std::filesystem::path& folder, const RunContext& context);

/// Writes a session folder, atomically. Reading it back gives the same bits.
void WriteSession(const std::filesystem::path& folder, const Session& session,
                  const RunContext& context);

}  // namespace acus::session
