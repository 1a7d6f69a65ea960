// The CT and the probe's plane over the video.
#pragma once

#include <memory>
#include <optional>

#include "acus/window/frame.h"
#include "acus/window/overlay.h"
#include "acus/window/space_layer.h"

namespace acus::window {

class VideoView {
 public:
  /// @param outline  As for OverlayRenderer. @throws InputError as it does.
  VideoView(const volume_rendering::PatientInView& patient, const mesh::Surface* outline,
            const OverlaySettings& settings);

  SpaceLayer& layer() { return layer_; }
  long num_overlays() const { return overlay_ ? overlay_->num_rendered() : 0; }

  /// @param place  Rectangle of the video's image in the window; empty: not shown.
  /// @param overlay_share  0: the video alone.
  void Update(const DisplayFrame& frame, const Rectangle& place, const Rectangle& window,
              double overlay_share);

 private:
  void UpdateOverlay(const DisplayFrame& frame, double share);
  void UpdatePlane(const DisplayFrame& frame, double share);

  SpaceLayer layer_;
  std::unique_ptr<OverlayRenderer> overlay_;
  OverlayImage image_;
  bool has_image_ = false;
  mesh::Surface painted_;  ///< The overlay's sheet in space.
  int sheet_ = -1;
  int plane_ = -1;
  std::shared_ptr<const acoustics::Probe> probe_;
};

}  // namespace acus::window
