#include "acus/base/core/input_file.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fcntl.h>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/machine.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

constexpr double kBytesPerGb = 1e9;
constexpr double kUnsuspiciousBytes = 2e9;
constexpr double kMaxRatio = 100.0;
constexpr double kShareOfAvailable = 0.5;  // Readers convert: for a moment data are there twice.

std::atomic<double> input_memory_gb{0.0};  ///< 0: the default. Set once, when a program starts.

std::string KindOf(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a named pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    default:
      return "not a file";
  }
}

double Gb(double bytes) {
  return std::ceil(bytes / kBytesPerGb * 10.0) / 10.0;
}

/// Where a comment that begins at `at` ends; `at` itself if none begins there.
std::size_t PastComment(std::string_view text, std::size_t at) {
  const std::string_view two = text.substr(at, 2);
  if (two != "//" && two != "/*") return at;
  const std::string_view end_mark = two == "//" ? "\n" : "*/";
  const std::size_t end = text.find(end_mark, at + 2);
  return end == text.npos ? text.size() : end + end_mark.size();
}

/// Where the string whose opening quote is at `at` ends.
std::size_t PastString(std::string_view text, std::size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at) {
    if (text[at] == '\\') ++at;
  }
  return at + 1;
}

}  // namespace

std::uintmax_t RequireInputFile(const fs::path& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  ACUS_REQUIRE(status.type() != fs::file_type::not_found, path.string(), ": no such file");
  ACUS_REQUIRE(status.type() != fs::file_type::none, path.string(),
               ": cannot be read: ", error.message());
  ACUS_REQUIRE(status.type() == fs::file_type::regular, path.string(), ": is ",
               KindOf(status.type()),
               "; a regular file is needed here. Copy its content to a file");
  const std::uintmax_t bytes = fs::file_size(path, error);
  ACUS_REQUIRE(!error && ::access(path.c_str(), R_OK) == 0, path.string(),
               ": cannot be read: ", error ? error.message() : "no permission");
  ACUS_REQUIRE(bytes <= max_bytes, path.string(), ": has ", bytes, " bytes; at most ", max_bytes,
               " are read here");
  return bytes;
}

double InputMemoryBytes() {
  const double gb = input_memory_gb.load();
  return gb > 0.0 ? gb * kBytesPerGb : kShareOfAvailable * AvailableMemoryBytes();
}

void SetInputMemory(std::optional<double> gb) {
  input_memory_gb.store(gb.value_or(0.0));
}

void RequireMemory(double declared_bytes, double file_bytes, const std::string& label) {
  const bool is_default = input_memory_gb.load() <= 0.0;
  const double most = InputMemoryBytes();
  ACUS_REQUIRE(declared_bytes <= most, label, ": declares ", Gb(declared_bytes), " GB, but ",
               std::floor(most / kBytesPerGb * 10.0) / 10.0, " GB are allowed for one input file",
               is_default ? " (half of the free memory)" : " (--memory-gb)",
               "; if the size is right, repeat with --memory-gb ", Gb(declared_bytes),
               " where memory suffices");
  ACUS_REQUIRE(
      !is_default || declared_bytes <= std::max(kUnsuspiciousBytes, kMaxRatio * file_bytes), label,
      ": declares ", Gb(declared_bytes), " GB, ",
      std::floor(declared_bytes / std::max(file_bytes, 1.0)),
      " times its size on the disk; if that is right, repeat with --memory-gb ",
      Gb(declared_bytes));
}

fs::path RequireDataBeside(const fs::path& header, const fs::path& data) {
  const fs::path plain = data.lexically_normal();
  ACUS_REQUIRE(!plain.empty() && !plain.is_absolute() && *plain.begin() != "..", header.string(),
               ": names the data file ", data.string(),
               ", which is outside of its folder, so it is not read; keep header and data in one "
               "folder, and name the data file without a path");
  return header.parent_path() / plain;
}

void RequireJsonDepth(std::string_view text, const std::string& label) {
  int depth = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"') {
      at = PastString(text, at);
      continue;
    }
    if (const std::size_t past = PastComment(text, at); past != at) {
      at = past;
      continue;
    }
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') --depth;
    ACUS_REQUIRE(depth <= kMaxJsonDepth, label, ": its JSON is nested more than ", kMaxJsonDepth,
                 " deep, at byte ", at, "; is it another kind of file?");
    ++at;
  }
}

}  // namespace acus
