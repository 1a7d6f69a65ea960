// Whether an output folder can be made, for programs that check before a long run.
#pragma once

#include <filesystem>

namespace acus {

/// Refuses what AtomicFolder (atomic_file.h, whose source defines this: the rules are one) would
/// refuse at its beginning, and leaves nothing behind.
/// @throws InputError as the constructor of AtomicFolder.
void RequireFolderCanBeMade(const std::filesystem::path& target, bool overwrite);

}  // namespace acus
