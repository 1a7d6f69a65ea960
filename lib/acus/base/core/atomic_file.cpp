#include "acus/base/core/atomic_file.h"

#include <atomic>
#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <string>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/output_check.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxTextBytes = std::uintmax_t{1} << 30U;

fs::path TemporaryName(const fs::path& target) {
  static std::atomic<int> counter{0};
  return target.parent_path() /
         Message(".partial-", ::getpid(), "-", counter++, "-", target.filename().string());
}

fs::path Absolute(fs::path target) {
  ACUS_REQUIRE(!target.empty(), "the output path is empty");
  // A link to a folder on another disk stays a link: what is behind it is written.
  std::error_code error;
  target = fs::absolute(target).lexically_normal();
  const fs::path real = fs::weakly_canonical(target, error);
  if (!error) target = real;
  if (target.filename().empty()) target = target.parent_path();
  return target;
}

void MakeParent(const fs::path& target) {
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  ACUS_REQUIRE(!error, target.parent_path().string(), ": cannot be made: ", error.message());
}

bool IsEmptyFolder(const fs::path& target) {
  return fs::is_directory(target) && fs::is_empty(target);
}

/// @throws InputError if the output that exists is not to be replaced.
void RequireReplaceable(const fs::path& target, bool overwrite) {
  if (IsEmptyFolder(target)) return;
  ACUS_REQUIRE(overwrite, target.string(),
               ": exists already; choose another folder or add --overwrite");
  ACUS_REQUIRE(fs::is_directory(target) && fs::exists(target / "provenance.json"), target.string(),
               ": is not the output of an earlier run (it has no provenance.json), so it is not "
               "replaced; choose another folder");
}

/// For file systems that cannot exchange two folders in one call.
void ReplaceInSteps(const fs::path& from, const fs::path& target, std::error_code& error) {
  const fs::path old = TemporaryName(target);
  std::error_code ignored;
  fs::rename(target, old, error);
  if (error) return;
  fs::rename(from, target, error);
  if (error) {
    fs::rename(old, target, ignored);
  } else {
    fs::remove_all(old, ignored);
  }
}

}  // namespace

AtomicFile::AtomicFile(fs::path target)
    : target_(Absolute(std::move(target))), temporary_(TemporaryName(target_)) {
  MakeParent(target_);
  ACUS_REQUIRE(!fs::is_directory(target_), target_.string(),
               ": is a folder; a file name is needed here");
  ACUS_REQUIRE(::access(target_.parent_path().c_str(), W_OK) == 0, target_.parent_path().string(),
               ": no permission to write here");
}

void AtomicFile::Commit() {
  std::error_code error;
  const auto hold = HoldTemporaries();
  fs::rename(path(), target_, error);
  ACUS_REQUIRE(!error, target_.string(), ": cannot be written: ", error.message());
}

void WriteTextFile(const fs::path& target, std::string_view text) {
  AtomicFile file(target);
  std::ofstream out(file.path(), std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  ACUS_REQUIRE(out, target.string(), ": cannot be written; is the disk full?");
  file.Commit();
}

AtomicFolder::AtomicFolder(fs::path target, bool overwrite)
    : target_(Absolute(std::move(target))),
      temporary_(TemporaryName(target_)),
      overwrite_(overwrite) {
  if (fs::exists(target_)) {
    if (fs::is_directory(target_)) lock_ = FolderLock(target_);
    RequireReplaceable(target_, overwrite_);
  }
  MakeParent(target_);
  std::error_code error;
  fs::create_directory(path(), error);
  ACUS_REQUIRE(!error, target_.string(), ": cannot be made: ", error.message());
}

void AtomicFolder::Commit() {
  const auto hold = HoldTemporaries();
  // An empty folder, or none, is replaced in one call that fails if it is not empty any more.
  std::error_code error;
  fs::rename(path(), target_, error);
  if (!error) return;
  ACUS_REQUIRE(fs::exists(target_), target_.string(),
               ": cannot be put in place: ", error.message());
  RequireReplaceable(target_, overwrite_);
  // It may have come to be there since the beginning: then another program may be writing it.
  const FolderLock lock = lock_.holds() ? FolderLock() : FolderLock(target_);
  // One exchange, so that there is no moment without a folder, even if the power fails now. What
  // was there is then under the temporary name, and goes with it.
  if (::renameat2(AT_FDCWD, path().c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) {
    return;
  }
  error.clear();
  ReplaceInSteps(path(), target_, error);
  ACUS_REQUIRE(!error, target_.string(), ": cannot be put in place: ", error.message());
}

void RequireFolderCanBeMade(const fs::path& target, bool overwrite) {
  const fs::path wanted = Absolute(target);
  std::error_code error;
  if (fs::exists(wanted, error)) {
    FolderLock lock;
    if (fs::is_directory(wanted)) lock = FolderLock(wanted);
    RequireReplaceable(wanted, overwrite);
  }
  fs::path first_missing = wanted;
  while (!fs::exists(first_missing.parent_path(), error) && first_missing.has_relative_path())
    first_missing = first_missing.parent_path();
  // Only making it shows whether it can be made: permissions, quotas, names that are too long.
  const Temporary trial(TemporaryName(first_missing));
  fs::create_directory(trial.path(), error);
  ACUS_REQUIRE(!error, wanted.string(), ": cannot be made: ", error.message());
  fs::create_directory(trial.path() / wanted.filename(), error);
  ACUS_REQUIRE(!error, wanted.string(), ": cannot be made: ", error.message());
}

std::string ReadTextFile(const fs::path& path) {
  const std::uintmax_t bytes = RequireInputFile(path, kMaxTextBytes);
  std::ifstream file(path, std::ios::binary);
  std::string text(bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(bytes));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(bytes), path.string(),
               ": cannot be read");
  return text;
}

}  // namespace acus
