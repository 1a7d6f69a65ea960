#include "acus/run/live/stream_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus::live {
namespace {

class DiskSink : public ByteSink {
 public:
  explicit DiskSink(const std::filesystem::path& file)
      : file_(open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644)) {
    ACUS_REQUIRE(file_ >= 0, file.string(), ": cannot be made: ", std::strerror(errno));
  }
  ~DiskSink() override { close(file_); }
  DiskSink(const DiskSink&) = delete;
  DiskSink& operator=(const DiskSink&) = delete;

  std::ptrdiff_t Write(std::string_view bytes) noexcept override {
    const ssize_t taken = write(file_, bytes.data(), bytes.size());
    return taken >= 0 ? taken : -errno;
  }

 private:
  int file_;
};

}  // namespace

std::unique_ptr<ByteSink> OpenOnDisk(const std::filesystem::path& file) {
  return std::make_unique<DiskSink>(file);
}

StreamFile::StreamFile(std::unique_ptr<ByteSink> sink, std::string_view header)
    : sink_(std::move(sink)) {
  blocks_.emplace_back(header) += '\n';
}

std::size_t StreamFile::pending_bytes() const noexcept {
  std::size_t sum = 0;
  for (const std::string& block : blocks_) sum += block.size();
  return sum - taken_;
}

int StreamFile::FlushFirstBlock() noexcept {
  const std::string_view block = blocks_.front();
  while (taken_ < block.size()) {
    const std::ptrdiff_t taken = sink_->Write(block.substr(taken_));
    if (taken == -EINTR) continue;
    if (taken < 0) return static_cast<int>(-taken);
    if (taken == 0) return ENOSPC;
    taken_ += static_cast<std::size_t>(taken);
  }
  return 0;
}

void StreamFile::DropFirstBlock() noexcept {
  blocks_.pop_front();
  taken_ = 0;
}

}  // namespace acus::live
