// What has been written survives a power failure.
#pragma once

#include <filesystem>

namespace acus {

/// Puts the files of a folder, without those of folders in it, and their names on the medium. May
/// take as long as the medium is slow. @returns 0, or the first errno.
int SyncFolder(const std::filesystem::path& folder) noexcept;

}  // namespace acus
