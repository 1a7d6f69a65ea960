// Cameras of this computer, and video files.
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/camera/frame_sources.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

/// False if it is no image of 8 bits.
bool Convert(const cv::Mat& frame, Image& out) {
  if (frame.empty() || frame.depth() != CV_8U) return false;
  if (frame.channels() != 1 && frame.channels() != 3) return false;
  out.Resize(frame.cols, frame.rows, frame.channels());
  cv::Mat to = MatOf(out);
  if (frame.channels() == 3) {
    cv::cvtColor(frame, to, cv::COLOR_BGR2RGB);
  } else {
    frame.copyTo(to);
  }
  out.time_ns = MonotonicNs();
  return true;
}

class DeviceSource final : public FrameSource {
 public:
  explicit DeviceSource(const std::string& device)
      : path_(device.find_first_not_of("0123456789") == std::string::npos ? "/dev/video" + device
                                                                          : device) {
    // What it has to say is in status(); its own lines would go to the user's terminal.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    status_.text = "looking for a camera at " + path_;
  }

  bool Next(Image& out, int timeout_ms) override {
    if (!capture_.isOpened() && !Open(timeout_ms)) return false;
    bool got = false;
    try {
      got = capture_.read(frame_) && Convert(frame_, out);
    } catch (const cv::Exception&) {
      got = false;
    }
    if (got) {
      ++status_.received;
      return true;
    }
    capture_.release();
    status_.connected = false;
    status_.text = "the camera at " + path_ +
                   " delivers no image: check its plug; it is tried again every second";
    return false;
  }
  bool finished() const override { return false; }
  FrameSourceStatus status() const override { return status_; }

 private:
  bool Open(int timeout_ms) {
    if (!retry_.Wait(timeout_ms)) return false;
    std::error_code ignored;
    if (!std::filesystem::exists(path_, ignored)) {
      status_.text = "there is no camera at " + path_ +
                     ": plug it in, or name another; it is tried again every second";
      return false;
    }
    try {
      if (!capture_.open(path_, cv::CAP_V4L2)) {
        status_.text = path_ +
                       " cannot be opened: another program may use it, or you may not read "
                       "it; it is tried again every second";
        return false;
      }
    } catch (const cv::Exception&) {
      status_.text = path_ + " is not a camera";
      return false;
    }
    status_.reconnects += was_open_ ? 1 : 0;
    was_open_ = true;
    status_.connected = true;
    status_.text = "camera at " + path_;
    return true;
  }

  std::string path_;
  cv::VideoCapture capture_;
  cv::Mat frame_;
  FrameSourceStatus status_;
  Pace retry_{kRetryNs};
  bool was_open_ = false;
};

class FilmSource final : public FrameSource {
 public:
  FilmSource(std::filesystem::path film, bool repeat, double pace_hz)
      : film_(std::move(film)),
        repeat_(repeat),
        pace_(pace_hz > 0.0 ? static_cast<std::int64_t>(1e9 / pace_hz) : 0) {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    ACUS_REQUIRE(std::filesystem::is_regular_file(film_), film_.string(),
                 ": there is no such video");
    ACUS_REQUIRE(Open(), film_.string(), ": is not a video that can be read");
    status_.connected = true;
    status_.text = "video " + film_.string();
  }

  bool Next(Image& out, int timeout_ms) override {
    if (finished_ || !pace_.Wait(timeout_ms)) return false;
    if (Read(out)) return true;
    if (repeat_ && status_.received > 0 && Open() && Read(out)) return true;
    finished_ = true;
    status_.connected = false;
    status_.text = "the video " + film_.string() + " is over";
    return false;
  }
  bool finished() const override { return finished_; }
  FrameSourceStatus status() const override { return status_; }

 private:
  bool Open() {
    try {
      return capture_.open(film_.string(), cv::CAP_FFMPEG);
    } catch (const cv::Exception&) {
      return false;
    }
  }
  bool Read(Image& out) {
    try {
      if (!capture_.read(frame_) || !Convert(frame_, out)) return false;
    } catch (const cv::Exception&) {
      return false;
    }
    ++status_.received;
    return true;
  }

  std::filesystem::path film_;
  bool repeat_;
  Pace pace_;
  cv::VideoCapture capture_;
  cv::Mat frame_;
  FrameSourceStatus status_;
  bool finished_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> OpenDevice(const std::string& device) {
  return std::make_unique<DeviceSource>(device);
}

std::unique_ptr<FrameSource> OpenFilm(const std::filesystem::path& film, bool repeat,
                                      double pace_hz) {
  return std::make_unique<FilmSource>(film, repeat, pace_hz);
}

}  // namespace acus::camera
