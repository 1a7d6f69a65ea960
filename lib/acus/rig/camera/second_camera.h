// The second camera of a pair: its image of the instant of the first one's.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acus/rig/camera/frame_source.h"
#include "acus/rig/camera/newest_frames.h"
#include "acus/rig/camera/stereo_pair.h"

namespace acus::camera {

struct SecondCameraOptions {
  std::string place;  ///< See OpenFrameSource.
  StereoPair pair;    ///< The first camera is the left one.
  int apart_ms = 12;  ///< Images that arrive further apart than this are not of one moment.
};

/// Whether images of a place are recorded, so that those of two belong together by their order.
bool IsRecorded(const std::string& place);

/// For one thread at a time.
class SecondCamera {
 public:
  /// @throws InputError as OpenFrameSource does.
  SecondCamera(const SecondCameraOptions& options, const FrameSourceOptions& source);

  /// The image of the instant of the first camera's: with recorded images the next one. Nothing if
  /// there is none, or none of the size in the pair's file.
  std::optional<Image> At(std::int64_t time_ns);
  /// What is wrong with its images; empty if nothing.
  std::string Problem() const;

 private:
  SecondCameraOptions options_;
  std::unique_ptr<FrameSource> recorded_;
  std::unique_ptr<NewestFrames> live_;
  std::string problem_;
};

}  // namespace acus::camera
