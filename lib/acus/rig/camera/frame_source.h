// Where images come from: a video device, a video file, a folder of images, a pipe, the network.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "acus/rig/camera/image.h"

namespace acus::camera {

struct FrameSourceStatus {
  bool connected = false;
  std::string text;  ///< For people: what is the matter and what is tried next.
  std::uint64_t received = 0;
  std::uint64_t bad = 0;         ///< Could not be read, or of another size than before.
  std::uint64_t reconnects = 0;  ///< Times that it came back.
};

/// For one thread at a time.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next image, in colour or grey. Waits at most `timeout_ms`, and less where there is
  /// nothing to wait for. False if there is none: see status(). A source that is lost is opened
  /// again, at most once a second. Never throws for what the source does.
  virtual bool Next(Image& out, int timeout_ms) = 0;
  /// No image will ever come again: the end of a video file or a folder that is not repeated.
  virtual bool finished() const = 0;
  virtual FrameSourceStatus status() const = 0;
};

struct FrameSourceOptions {
  /// Video files, folders and images are given at this rate; 0: as fast as they are requested.
  double pace_hz = 0.0;
};

/// @param place
///     "device:0" or "device:/dev/video0": a camera of this computer;
///     "video:PATH": a video that ffmpeg reads; "folder:PATH": images of a folder by name; with
///     "film-loop:" and "folder-loop:" they begin again at their end;
///     "pipe:PATH": a named pipe or file of binary PGM or PPM images, one after the other;
///     "igtl:HOST:PORT" or "igtl:HOST:PORT/STREAM": images of an OpenIGTLink server.
/// A device, pipe or server that is not there now is waited for.
/// @throws InputError for another kind of place, or a video file or folder that is not there.
std::unique_ptr<FrameSource> OpenFrameSource(const std::string& place,
                                             const FrameSourceOptions& options = {});

}  // namespace acus::camera
