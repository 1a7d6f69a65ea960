// A file in memory without reading it. Private to this module.
#pragma once

#include <cstddef>
#include <filesystem>

namespace acus::mechanics {

/// Maps a whole file, read-only. The system reads the pages that are used. A file that is replaced
/// (renamed over) meanwhile stays as it was; one that is cut off in place does not.
class MappedFile {
 public:
  /// @throws InputError if `path` is no file, cannot be opened or is empty.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::byte* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace acus::mechanics
