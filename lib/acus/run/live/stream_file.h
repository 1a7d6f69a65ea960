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

/// Where bytes go. Injected by tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Takes some or all of the bytes, in order. Returns how many, or -errno.
  virtual std::ptrdiff_t Write(std::string_view bytes) noexcept = 0;
};

using SinkFactory = std::function<std::unique_ptr<ByteSink>(const std::filesystem::path& file)>;

/// A new file. @throws InputError if it cannot be made, or is there already.
std::unique_ptr<ByteSink> OpenOnDisk(const std::filesystem::path& file);

/// Keeps what the sink has not taken yet, in blocks.
class StreamFile {
 public:
  StreamFile(std::unique_ptr<ByteSink> sink, std::string_view header);

  /// Append rows here: to the last block.
  std::string& rows() noexcept { return blocks_.back(); }
  void BeginBlock() { blocks_.emplace_back(); }
  std::size_t pending_bytes() const noexcept;

  /// Hands the first block over, as much of it as the sink takes. Returns 0 if it has all of it, or
  /// else an errno.
  int FlushFirstBlock() noexcept;
  /// @pre FlushFirstBlock() returned 0, and it is not the only block.
  void DropFirstBlock() noexcept;

 private:
  std::unique_ptr<ByteSink> sink_;
  std::deque<std::string> blocks_;
  std::size_t taken_ = 0;  ///< Of the first block, by the sink.
};

}  // namespace acus::live
