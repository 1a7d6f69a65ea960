// A folder that is being written is locked: no other program replaces it or records into it.
#pragma once

#include <filesystem>

namespace acus {

/// Holds the lock of a folder (flock) until it is destroyed; the system releases it when the
/// process ends, however it ends. A file system without locks locks nothing.
class FolderLock {
 public:
  FolderLock() = default;  ///< Holds nothing.
  /// @param folder  An existing folder.
  /// @throws InputError if another process, or another lock of this one, holds it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;

  bool holds() const { return file_ >= 0; }

 private:
  int file_ = -1;
};

}  // namespace acus
