#include "acus/base/core/trusted_library.h"

#include <cerrno>
#include <cstring>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRule =
    "; a library and each folder above it must belong to root or to you, and no one else may write "
    "them (a folder with the sticky bit excepted). ";

/// Throws if someone else than root and this user can change what lies at `path`.
void CheckEntry(const fs::path& path, const std::string& where) {
  struct stat entry {};
  ACUS_REQUIRE(stat(path.c_str(), &entry) == 0, where, ": ", path.string(), ": ",
               std::strerror(errno));
  ACUS_REQUIRE(entry.st_uid == 0 || entry.st_uid == geteuid(), where, ": ", path.string(),
               " belongs to the user with number ", entry.st_uid, kRule,
               "Copy the library to a folder of yours, or have it installed");
  const bool is_shared = (entry.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  const bool is_sticky = S_ISDIR(entry.st_mode) && (entry.st_mode & S_ISVTX) != 0;
  ACUS_REQUIRE(!is_shared || is_sticky, where, ": ", path.string(), " may be written by ",
               (entry.st_mode & S_IWOTH) != 0 ? "everybody" : "its group", kRule,
               "Take that right away: chmod go-w '", path.string(), "'");
}

}  // namespace

void CheckLibraryWord(const std::string& library, const std::string& where) {
  constexpr const char* kAllowed =
      "; allowed: an absolute path such as /opt/vendor/lib/libX.so, or a name without a slash, "
      "which is looked for where the system keeps its libraries";
  const bool is_name = library.find('/') == std::string::npos;
  ACUS_REQUIRE(is_name || library.front() == '/', where, ": is '", library,
               "', which depends on the working directory", kAllowed);
  ACUS_REQUIRE(library.find('$') == std::string::npos, where, ": is '", library,
               "'; the loader would replace what follows the $", kAllowed);
}

fs::path TrustedFile(const std::string& path, const std::string& where) {
  std::error_code error;
  const fs::path file = fs::canonical(path, error);
  ACUS_REQUIRE(error != std::errc::no_such_file_or_directory, where, ": ", path, ": no such file");
  ACUS_REQUIRE(!error, where, ": ", path, ": ", error.message());
  ACUS_REQUIRE(fs::is_regular_file(file, error), where, ": ", path, " is not a regular file");
  CheckEntry(file, where);
  for (fs::path at = file; at.has_relative_path();) {
    at = at.parent_path();
    CheckEntry(at, where);
  }
  return file;
}

}  // namespace acus
