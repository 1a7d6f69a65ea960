// The kinds of places that images come from; see frame_source.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "acus/rig/camera/frame_source.h"

namespace acus::camera {

std::unique_ptr<FrameSource> OpenDevice(const std::string& device);
std::unique_ptr<FrameSource> OpenFilm(const std::filesystem::path& film, bool repeat,
                                      double pace_hz);
std::unique_ptr<FrameSource> OpenFolder(const std::filesystem::path& folder, bool repeat,
                                        double pace_hz);
std::unique_ptr<FrameSource> OpenPipe(const std::filesystem::path& pipe);
std::unique_ptr<FrameSource> OpenNetwork(const std::string& host, int port,
                                         const std::string& stream);

/// Says when the next try, or the next image, is due.
class Pace {
 public:
  /// @param interval_ns  0: always due.
  explicit Pace(std::int64_t interval_ns) : interval_ns_(interval_ns) {}
  /// Waits until it is due, at most so long; false if it is not due then. Being due is used up.
  bool Wait(int timeout_ms);

 private:
  std::int64_t interval_ns_;
  std::int64_t due_ns_ = 0;
};

inline constexpr std::int64_t kRetryNs = 1'000'000'000;

}  // namespace acus::camera
