// Where the loader looks for a library that is given by its name alone.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace acus {

/// Folders that the loader searches for this program, as it took them up when the program began:
/// those of LD_LIBRARY_PATH, and the program's own if it has any; last the system's.
std::vector<std::string> LoaderFolders();

/// Throws if an entry is empty or relative: the loader takes it for the working directory, for the
/// library itself and for what that one needs.  @throws InputError
void CheckSearch(const std::vector<std::string>& folders);

/// The paths of the loader's cache (/etc/ld.so.cache) for `name`. Empty if there are none, or if
/// the cache is damaged.
/// @param cache  the bytes of the file.
std::vector<std::string> PathsInCache(std::string_view cache, std::string_view name);

/// The file that the loader takes for `name`; empty if there is none. Loads nothing.
std::filesystem::path FindSystemLibrary(const std::string& name);

}  // namespace acus
