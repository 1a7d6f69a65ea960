#include "acus/base/core/atomic_file.h"

#include <atomic>
#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <string>
#include <unistd.h>

#include "acus/base/core/error.h"

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

bool IsEarlierOutput(const fs::path& folder) {
  return fs::is_directory(folder) &&
         (fs::is_empty(folder) || fs::exists(folder / "provenance.json"));
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

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void AtomicFile::Commit() {
  std::error_code error;
  fs::rename(temporary_, target_, error);
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
    : target_(Absolute(std::move(target))), temporary_(TemporaryName(target_)) {
  if (fs::exists(target_) && !(fs::is_directory(target_) && fs::is_empty(target_))) {
    ACUS_REQUIRE(overwrite, target_.string(),
                 ": exists already; choose another folder or add --overwrite");
    ACUS_REQUIRE(IsEarlierOutput(target_), target_.string(),
                 ": is not the output of an earlier run (it has no provenance.json), so it is not "
                 "replaced; choose another folder");
  }
  MakeParent(target_);
  std::error_code error;
  fs::create_directory(temporary_, error);
  ACUS_REQUIRE(!error, target_.string(), ": cannot be made: ", error.message());
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void AtomicFolder::Commit() {
  std::error_code error;
  if (!fs::exists(target_) || fs::is_empty(target_)) {
    fs::rename(temporary_, target_, error);  // An empty folder is replaced by the system.
    ACUS_REQUIRE(!error, target_.string(), ": cannot be put in place: ", error.message());
    return;
  }
  // One exchange, so that there is no moment without a folder, even if the power fails now. What
  // was there is then under the temporary name, and goes with it.
  if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) {
    return;
  }
  // Not every file system can exchange.
  const fs::path old = TemporaryName(target_);
  fs::rename(target_, old, error);
  if (!error) {
    fs::rename(temporary_, target_, error);
    std::error_code ignored;
    if (error) {
      fs::rename(old, target_, ignored);
    } else {
      fs::remove_all(old, ignored);
    }
  }
  ACUS_REQUIRE(!error, target_.string(), ": cannot be put in place: ", error.message());
}

std::string ReadTextFile(const fs::path& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  ACUS_REQUIRE(!error, path.string(), ": cannot be read: ", error.message());
  ACUS_REQUIRE(bytes <= kMaxTextBytes, path.string(), ": has ", bytes,
               " bytes; a text file of at most ", kMaxTextBytes, " is read here");
  std::ifstream file(path, std::ios::binary);
  std::string text(bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(bytes));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(bytes), path.string(),
               ": cannot be read");
  return text;
}

}  // namespace acus
