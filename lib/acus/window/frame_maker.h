// Converts the data of a live session to the content of its window.
#pragma once

#include <memory>
#include <optional>

#include "acus/physics/breathing/motion_map.h"
#include "acus/rig/camera/camera_tracker.h"
#include "acus/run/live/live_session.h"
#include "acus/run/training/structures.h"
#include "acus/window/frame.h"
#include "acus/window/tissue_watch.h"

namespace acus::window {

/// Fills one frame, and keeps its buffers.
class FrameMaker {
 public:
  /// @param session  Must outlive this.
  /// @param trial  Number of the trainee's trial, from 1: hints become rarer with it.
  /// @param caption  Below the exercise's name; may be empty.
  explicit FrameMaker(const live::LiveSession& session, int trial = 1, std::string caption = {});

  /// @param image  The newest of the session.  @param video  Null: no camera, or no image yet.
  /// @param steers_probe  Mouse and keys move the probe, else the needle.
  const DisplayFrame& Make(const live::LiveImage& image, const camera::CameraView* video,
                           bool steers_probe = false);

  /// A note that frames show until the next one; empty: none.
  void SetNotice(std::string text) { notice_ = std::move(text); }

 private:
  void AddTools(const live::LiveImage& image);
  void AddImages(const live::LiveImage& image);
  void AddVideo(const camera::CameraView* video);
  void AddReadouts(const live::LiveImage& image);
  void AddExercise(const live::LiveImage& image, bool steers_probe);

  const live::LiveSession& session_;
  int trial_;
  std::string caption_;
  std::string notice_;
  training::LabelAtPoint label_at_;  ///< In CT space; empty: the scene has no labels.
  std::optional<breathing::MotionMap> motion_;
  TissueWatch tissue_;
  DisplayFrame frame_;
  std::uint64_t camera_shown_ = 0;  ///< Number of the camera's image in frame_; 0: none.
  std::uint64_t camera_dropped_ = 0;
};

}  // namespace acus::window
