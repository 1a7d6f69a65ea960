#include "acus/base/core/sync_folder.h"

#include <cerrno>
#include <exception>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

namespace acus {
namespace {

int SyncOne(const std::filesystem::path& path, int flags) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags);
  if (file < 0) return errno;
  const int error = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  // Some file systems have no such call.
  return error == EINVAL || error == ENOTSUP ? 0 : error;
}

}  // namespace

int SyncFolder(const std::filesystem::path& folder) noexcept {
  try {
    int first = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      const int error = SyncOne(entry.path(), 0);
      if (first == 0) first = error;
    }
    const int error = SyncOne(folder, O_DIRECTORY);
    return first != 0 ? first : error;
  } catch (const std::filesystem::filesystem_error& error) {
    return error.code().value();
  } catch (const std::exception&) {
    return ENOMEM;
  }
}

}  // namespace acus
