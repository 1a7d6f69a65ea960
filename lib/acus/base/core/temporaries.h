// Hidden files and folders that outputs are written under: none outlives the program.
#pragma once

#include <filesystem>
#include <mutex>

namespace acus {

/// A temporary name that is known while this lives; what is there is removed at the end.
class Temporary {
 public:
  explicit Temporary(std::filesystem::path path);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// While this is held, RemoveTemporaries() waits: an output is put in place or removed, not both.
std::unique_lock<std::mutex> HoldTemporaries();

/// Removes everything that is known, from any thread, and holds the lock from then on: the caller
/// ends the process.
void RemoveTemporaries() noexcept;

}  // namespace acus
