// From what a live session publishes to what its window shows.
#pragma once

#include <memory>
#include <optional>

#include "acus/physics/breathing/motion_map.h"
#include "acus/rig/camera/camera_tracker.h"
#include "acus/run/live/live_session.h"
#include "acus/window/frame.h"

namespace acus::window {

/// Fills one frame, whose buffers it keeps.
class FrameMaker {
 public:
  /// @param session  Must outlive this.
  explicit FrameMaker(const live::LiveSession& session);

  /// @param picture  The newest of the session.  @param video  Null: no camera, or nothing yet.
  const DisplayFrame& Make(const live::LivePicture& picture, const camera::CameraView* video);

 private:
  void AddTools(const live::LivePicture& picture);
  void AddPictures(const live::LivePicture& picture);
  void AddVideo(const camera::CameraView& video);
  void AddReadouts(const live::LivePicture& picture);

  const live::LiveSession& session_;
  std::optional<breathing::MotionMap> motion_;
  DisplayFrame frame_;
};

}  // namespace acus::window
