// Outputs appear whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include "acus/base/core/folder_lock.h"
#include "acus/base/core/temporaries.h"

namespace acus {

/// A file that is written under a hidden temporary name in the same folder, with the same
/// extension (writers choose the format by it), and renamed on Commit(). Without Commit() the
/// destructor removes it.
class AtomicFile {
 public:
  /// @throws InputError if the folder of `target` cannot be made or written to.
  explicit AtomicFile(std::filesystem::path target);

  /// Write here.
  const std::filesystem::path& path() const { return temporary_.path(); }

  /// @throws InputError if the file cannot be put in place (disk full, no permission).
  void Commit();

 private:
  std::filesystem::path target_;
  Temporary temporary_;
};

/// Writes `text` to `target`, whole or not at all.
void WriteTextFile(const std::filesystem::path& target, std::string_view text);

/// A folder that is filled under a hidden temporary name and renamed on Commit().
class AtomicFolder {
 public:
  /// @param overwrite  An existing `target` is replaced on Commit(), but only if it is empty or
  ///     holds a `provenance.json`, that is, if it is an earlier output.
  /// @throws InputError if `target` exists and may not be replaced, is being written by another
  ///     program, or cannot be made.
  AtomicFolder(std::filesystem::path target, bool overwrite);

  /// Write here.
  const std::filesystem::path& path() const { return temporary_.path(); }

  /// Puts the folder in place. Without `overwrite`, a folder that has come to be there meanwhile is
  /// not replaced. @throws InputError as above.
  void Commit();

 private:
  std::filesystem::path target_;
  Temporary temporary_;
  bool overwrite_;
  FolderLock lock_;  ///< Of the folder that will be replaced.
};

/// The content of a text file. @throws InputError if it cannot be read or is larger than 1 GiB.
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace acus
