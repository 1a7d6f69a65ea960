// Images of a folder, of a named pipe, and of an OpenIGTLink server.
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <poll.h>
#include <thread>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/camera/frame_sources.h"
#include "acus/rig/tracking/igtl_source.h"

namespace acus::camera {
namespace {

constexpr int kLargestSidePx = 8192;

class FolderSource final : public FrameSource {
 public:
  FolderSource(const std::filesystem::path& folder, bool repeat, double pace_hz)
      : repeat_(repeat), pace_(pace_hz > 0.0 ? static_cast<std::int64_t>(1e9 / pace_hz) : 0) {
    files_ = ImageFiles(folder);
    status_.connected = true;
    status_.text = "images of " + folder.string();
  }

  bool Next(Image& out, int timeout_ms) override {
    if (finished_ || !pace_.Wait(timeout_ms)) return false;
    // At most once around: a folder of broken images must not hold up whoever waits.
    for (std::size_t tries = 0; tries < files_.size(); ++tries) {
      if (next_ == files_.size()) {
        if (!repeat_) break;
        next_ = 0;
      }
      try {
        out = ReadImage(files_[next_++]);
        out.time_ns = MonotonicNs();
        ++status_.received;
        return true;
      } catch (const InputError& error) {
        ++status_.bad;
        status_.text = error.what();
      }
    }
    finished_ = !repeat_ && next_ == files_.size();
    status_.connected = !finished_;
    return false;
  }
  bool finished() const override { return finished_; }
  FrameSourceStatus status() const override { return status_; }

 private:
  std::vector<std::filesystem::path> files_;
  bool repeat_;
  Pace pace_;
  std::size_t next_ = 0;
  FrameSourceStatus status_;
  bool finished_ = false;
};

/// What a header of PGM or PPM says, and how long it is; nothing while it is not complete.
struct PnmHeader {
  int channels = 0;  ///< 0: it is no header.
  int width_px = 0;
  int height_px = 0;
  std::size_t length = 0;
};
std::optional<PnmHeader> ParseHeader(const std::string& bytes) {
  if (bytes.size() < 2) return std::nullopt;
  PnmHeader header;
  if (bytes[0] != 'P' || (bytes[1] != '5' && bytes[1] != '6')) return header;
  std::size_t at = 2;
  std::array<int, 3> numbers{};
  for (int& number : numbers) {
    while (at < bytes.size() && std::isspace(static_cast<unsigned char>(bytes[at])) != 0) ++at;
    const std::size_t from = at;
    for (; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9'; ++at) {
      number = std::min(10 * number + (bytes[at] - '0'), 1'000'000);
    }
    if (at == bytes.size()) return at < 64 ? std::nullopt : std::optional(header);
    if (at == from) return header;
  }
  if (std::isspace(static_cast<unsigned char>(bytes[at])) == 0 || numbers[2] != 255) return header;
  if (std::min(numbers[0], numbers[1]) < 1 || std::max(numbers[0], numbers[1]) > kLargestSidePx) {
    return header;
  }
  return PnmHeader{bytes[1] == '5' ? 1 : 3, numbers[0], numbers[1], at + 1};
}

class PipeSource final : public FrameSource {
 public:
  explicit PipeSource(std::filesystem::path pipe) : path_(std::move(pipe)) {
    status_.text = "waiting for images from " + path_.string();
  }
  ~PipeSource() override { Close(); }

  bool Next(Image& out, int timeout_ms) override {
    const std::int64_t until = MonotonicNs() + std::int64_t{timeout_ms} * 1'000'000;
    do {
      if (Take(out)) return true;
      if (finished_ || !Fill(std::max<std::int64_t>(0, until - MonotonicNs()) / 1'000'000)) {
        return false;
      }
    } while (MonotonicNs() < until);
    return Take(out);
  }
  bool finished() const override { return finished_; }
  FrameSourceStatus status() const override { return status_; }

 private:
  void Close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }

  bool Open(int timeout_ms) {
    if (!retry_.Wait(timeout_ms)) return false;
    file_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file_ < 0) {
      status_.text = path_.string() + " cannot be opened (" + std::strerror(errno) +
                     "); it is tried again every second";
      return false;
    }
    is_file_ = std::filesystem::is_regular_file(path_);
    return true;
  }

  /// Reads what is there, waiting for it. False if nothing can come for now.
  bool Fill(std::int64_t timeout_ms) {
    if (file_ < 0 && !Open(static_cast<int>(timeout_ms))) return false;
    pollfd waiting{file_, POLLIN, 0};
    if (!is_file_ && ::poll(&waiting, 1, static_cast<int>(timeout_ms)) <= 0) return false;
    char chunk[1 << 16];
    const ssize_t count = ::read(file_, chunk, sizeof chunk);
    if (count > 0) {
      bytes_.append(chunk, static_cast<std::size_t>(count));
      if (!status_.connected) status_.reconnects += was_open_ ? 1 : 0;
      was_open_ = status_.connected = true;
      return true;
    }
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    finished_ = is_file_;
    status_.bad += bytes_.empty() ? 0 : 1;  // The writer went away within an image.
    bytes_.clear();
    status_.text = path_.string() + (is_file_ ? " is over" : ": whoever sent images has gone");
    status_.connected = false;
    Close();
    return false;
  }

  bool Take(Image& out) {
    while (true) {
      const auto header = ParseHeader(bytes_);
      if (!header) return false;
      if (header->channels == 0) {
        SkipRubbish();
        continue;
      }
      const std::size_t size = static_cast<std::size_t>(header->channels) *
                               static_cast<std::size_t>(header->width_px) *
                               static_cast<std::size_t>(header->height_px);
      if (bytes_.size() < header->length + size) return false;
      out.Resize(header->width_px, header->height_px, header->channels);
      std::copy_n(bytes_.data() + header->length, size, out.pixels.data());
      out.time_ns = MonotonicNs();
      bytes_.erase(0, header->length + size);
      ++status_.received;
      status_.text = "images from " + path_.string();
      in_rubbish_ = false;
      return true;
    }
  }

  void SkipRubbish() {
    if (!in_rubbish_) ++status_.bad;
    in_rubbish_ = true;
    const auto next = bytes_.find('P', 1);
    bytes_.erase(0, next == std::string::npos ? bytes_.size() : next);
    status_.text = path_.string() + " sends what is not a PGM or PPM image";
  }

  std::filesystem::path path_;
  int file_ = -1;
  bool is_file_ = false, was_open_ = false, finished_ = false, in_rubbish_ = false;
  std::string bytes_;
  FrameSourceStatus status_;
  Pace retry_{kRetryNs};
};

class NetworkSource final : public FrameSource {
 public:
  NetworkSource(const std::string& host, int port, const std::string& stream)
      : source_(Options(host, port)),
        stream_(stream),
        place_(host + ":" + std::to_string(port) + (stream.empty() ? "" : "/" + stream)) {
    source_.Start();
  }

  bool Next(Image& out, int timeout_ms) override {
    const std::int64_t until = MonotonicNs() + std::int64_t{timeout_ms} * 1'000'000;
    while (true) {
      const auto image = source_.Image(stream_);
      if (image != nullptr && (image->number != last_number_ || image->time_ns != last_time_ns_)) {
        last_number_ = image->number;
        last_time_ns_ = image->time_ns;
        out.width_px = image->image.width;
        out.height_px = image->image.height;
        out.channels = image->image.channels;
        out.pixels = image->image.pixels;
        out.time_ns = image->time_ns;
        ++received_;
        return true;
      }
      if (MonotonicNs() >= until) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  bool finished() const override { return false; }
  FrameSourceStatus status() const override {
    const tracking::SourceStatus link = source_.status();
    FrameSourceStatus status;
    status.connected = link.state == tracking::SourceState::kConnected;
    status.text = "images from " + place_ + ": " + tracking::Name(link.state);
    if (!status.connected && !link.last_error.empty()) status.text += " (" + link.last_error + ")";
    status.received = received_;
    status.bad = link.counts.bad_messages;
    status.reconnects = link.counts.connects > 0 ? link.counts.connects - 1 : 0;
    return status;
  }

 private:
  static tracking::IgtlOptions Options(const std::string& host, int port) {
    tracking::IgtlOptions options;
    options.name = "camera";
    options.host = host;
    options.port = port;
    options.keep_images = true;
    return options;
  }
  tracking::IgtlSource source_;
  std::string stream_, place_;
  std::uint64_t last_number_ = 0, received_ = 0;
  std::int64_t last_time_ns_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> OpenFolder(const std::filesystem::path& folder, bool repeat,
                                        double pace_hz) {
  return std::make_unique<FolderSource>(folder, repeat, pace_hz);
}
std::unique_ptr<FrameSource> OpenPipe(const std::filesystem::path& pipe) {
  return std::make_unique<PipeSource>(pipe);
}
std::unique_ptr<FrameSource> OpenNetwork(const std::string& host, int port,
                                         const std::string& stream) {
  return std::make_unique<NetworkSource>(host, port, stream);
}

}  // namespace acus::camera
