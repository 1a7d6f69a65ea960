// From what a live session publishes to what its window shows.
#pragma once

#include <memory>
#include <optional>

#include "breathing/motion_map.h"
#include "camera/camera_tracker.h"
#include "display/frame.h"
#include "live/live_session.h"

namespace acus::console {

/// Fills one frame, whose buffers it keeps.
class FrameMaker {
 public:
  /// @param session  Must outlive this.
  explicit FrameMaker(const live::LiveSession& session);

  /// @param picture  The newest of the session.  @param video  Null: no camera, or nothing yet.
  const display::DisplayFrame& Make(const live::LivePicture& picture,
                                    const camera::CameraView* video);

 private:
  void AddTools(const live::LivePicture& picture);
  void AddPictures(const live::LivePicture& picture);
  void AddVideo(const camera::CameraView& video);
  void AddReadouts(const live::LivePicture& picture);

  const live::LiveSession& session_;
  std::optional<breathing::MotionMap> motion_;
  display::DisplayFrame frame_;
};

}  // namespace acus::console
