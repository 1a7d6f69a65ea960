#include "acus/rig/camera/frame_source.h"

#include <algorithm>
#include <charconv>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/camera/frame_sources.h"

namespace acus::camera {
namespace {

std::unique_ptr<FrameSource> OpenAddress(const std::string& address, const std::string& place) {
  const auto colon = address.rfind(':');
  const auto slash = address.find('/', colon == std::string::npos ? 0 : colon);
  int port = 0;
  if (colon != std::string::npos && colon > 0) {
    const char* end = address.data() + (slash == std::string::npos ? address.size() : slash);
    const auto parsed = std::from_chars(address.data() + colon + 1, end, port);
    if (parsed.ec != std::errc() || parsed.ptr != end) port = 0;
  }
  ACUS_REQUIRE(port > 0 && port < 65536, "images from '", place,
               "': not understood; write igtl:HOST:PORT or igtl:HOST:PORT/STREAM, such as "
               "igtl:localhost:18944/Camera");
  return OpenNetwork(address.substr(0, colon), port,
                     slash == std::string::npos ? "" : address.substr(slash + 1));
}

}  // namespace

bool Pace::Wait(int timeout_ms) {
  if (interval_ns_ == 0) return true;
  const std::int64_t now = MonotonicNs();
  const std::int64_t wait_ns = due_ns_ - now;
  const std::int64_t most_ns = std::int64_t{timeout_ms} * 1'000'000;
  if (wait_ns > 0)
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(wait_ns, most_ns)));
  if (wait_ns > most_ns) return false;
  // In step with the first one, unless it fell behind.
  due_ns_ = std::max(due_ns_ + interval_ns_, now);
  return true;
}

std::unique_ptr<FrameSource> OpenFrameSource(const std::string& place,
                                             const FrameSourceOptions& options) {
  ACUS_REQUIRE(options.pace_hz >= 0.0 && options.pace_hz <= 1000.0, "images at ", options.pace_hz,
               " Hz; allowed is 0 to 1000");
  const auto colon = place.find(':');
  const std::string kind = place.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : place.substr(colon + 1);
  ACUS_REQUIRE(
      !rest.empty(), "images from '", place,
      "': not understood; allowed are device:, video:, video-loop:, folder:, folder-loop:, "
      "pipe: and igtl:, each with a name after it, such as device:0");
  if (kind == "device") return OpenDevice(rest);
  // "film" is the older word.
  if (kind == "video" || kind == "video-loop" || kind == "film" || kind == "film-loop") {
    return OpenFilm(rest, kind.ends_with("-loop"), options.pace_hz);
  }
  if (kind == "folder" || kind == "folder-loop") {
    return OpenFolder(rest, kind == "folder-loop", options.pace_hz);
  }
  if (kind == "pipe") return OpenPipe(rest);
  ACUS_REQUIRE(
      kind == "igtl", "images from '", place, "': '", kind,
      "' is not known; allowed are device, video, video-loop, folder, folder-loop, pipe and "
      "igtl");
  return OpenAddress(rest, place);
}

}  // namespace acus::camera
