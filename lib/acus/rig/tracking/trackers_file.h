// The trackers of a file of configs/devices (format acus-devices/1).
#pragma once

#include <filesystem>
#include <vector>

#include "acus/rig/tracking/igtl_source.h"

namespace acus::tracking {

/// One for each tracker of the file, ready for IgtlSource; empty if it names none.
/// @throws InputError: what the schema says; a quaternion whose length is not 1; a tool that is
///     named twice, within a tracker or in two of them.
std::vector<IgtlOptions> ReadTrackers(const std::filesystem::path& path);

}  // namespace acus::tracking
