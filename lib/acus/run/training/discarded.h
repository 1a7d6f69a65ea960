// Sessions that were discarded: their files stay, but no curriculum, study or progress counts them.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::training {

/// The file in a session's folder that marks it as discarded: the JSON keys reason and time.
inline constexpr const char* kDiscardedFile = "discarded.json";

/// True if the folder, or its parent (a run folder is in its session's), is marked.
bool IsDiscarded(const std::filesystem::path& folder);

/// The run folders whose sessions are not discarded, in their order; one warning for each of the
/// others.
/// @throws InputError if none remains.
std::vector<std::filesystem::path> KeptRuns(std::span<const std::filesystem::path> runs,
                                            RunContext& context);

}  // namespace acus::training
