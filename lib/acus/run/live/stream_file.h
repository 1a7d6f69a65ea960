// A file that rows are appended to, on a disk that may be full or slow.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace acus::live {

/// Receives bytes. Injected by tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Writes some or all of the bytes, in order. Returns their number, or -errno.
  virtual std::ptrdiff_t Write(std::string_view bytes) noexcept = 0;
};

using SinkFactory = std::function<std::unique_ptr<ByteSink>(const std::filesystem::path& file)>;

/// A new file. @throws InputError if it cannot be created, or exists already.
std::unique_ptr<ByteSink> OpenOnDisk(const std::filesystem::path& file);

/// Keeps bytes that the sink has not accepted yet, in blocks.
class StreamFile {
 public:
  StreamFile(std::unique_ptr<ByteSink> sink, std::string_view header);

  /// Append rows here: to the last block.
  std::string& rows() noexcept { return blocks_.back(); }
  void BeginBlock() { blocks_.emplace_back(); }
  std::size_t pending_bytes() const noexcept;

  /// Writes the first block, as much of it as the sink accepts. Returns 0 if that is all of it, or
  /// else an errno.
  int FlushFirstBlock() noexcept;
  /// @pre FlushFirstBlock() returned 0, and it is not the only block.
  void DropFirstBlock() noexcept;

 private:
  std::unique_ptr<ByteSink> sink_;
  std::deque<std::string> blocks_;
  std::size_t taken_ = 0;  ///< Bytes of the first block that the sink has accepted.
};

}  // namespace acus::live
