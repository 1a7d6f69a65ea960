#include "acus/base/core/line_reader.h"

#include <array>
#include <cerrno>
#include <poll.h>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus {

void LineReader::Read(int timeout_ms) {
  pollfd waits{.fd = descriptor_, .events = POLLIN, .revents = 0};
  if (ended_ || ::poll(&waits, 1, timeout_ms) <= 0) return;
  std::array<char, 4096> bytes;
  const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
  if (count > 0) {
    buffer_.append(bytes.data(), static_cast<std::size_t>(count));
  } else if (count == 0 || (errno != EINTR && errno != EAGAIN)) {
    ended_ = true;
  }
}

std::optional<std::string> LineReader::TakeLine() {
  std::size_t end = buffer_.find('\n');
  if (end == std::string::npos) {
    if (!ended_ || buffer_.empty()) return std::nullopt;
    end = buffer_.size();
  }
  std::string line = buffer_.substr(0, end);
  buffer_.erase(0, end + 1);
  return line;
}

std::optional<std::string> LineReader::Next(int timeout_ms) {
  auto line = TakeLine();
  if (!line) {
    Read(timeout_ms);
    line = TakeLine();
  }
  if (line && skips_) {
    skips_ = false;
    return std::nullopt;
  }
  if (!line && buffer_.size() > kMaxLineBytes) {
    buffer_.clear();
    const bool is_new = !skips_;
    skips_ = true;
    ACUS_REQUIRE(!is_new, "a line of more than ", kMaxLineBytes, " bytes; it is passed over");
  }
  return line;
}

}  // namespace acus
