// Lines of a pipe or terminal, without waiting for them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace acus {

class LineReader {
 public:
  static constexpr std::size_t kMaxLineBytes = 1U << 16;

  /// @param descriptor  Open for reading; stays the caller's.
  explicit LineReader(int descriptor) : descriptor_(descriptor) {}

  /// The next line without its end, if it has come within the time. The last one may lack its end.
  /// @throws InputError for a line of more than kMaxLineBytes; the rest of it is passed over.
  std::optional<std::string> Next(int timeout_ms);

  /// Nothing more will come.
  bool at_end() const { return ended_ && buffer_.empty(); }

 private:
  std::optional<std::string> TakeLine();
  void Read(int timeout_ms);

  int descriptor_;
  std::string buffer_;
  bool ended_ = false;
  bool skips_ = false;  ///< The rest of a line that was too long.
};

}  // namespace acus
