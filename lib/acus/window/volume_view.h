// The patient by volume rendering: which images to render, and at which resolution.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/orbit.h"
#include "acus/window/steering.h"
#include "acus/window/volume_renderer.h"

namespace acus::window {

struct VolumeViewSettings {
  /// Ratio of the image's width and height to the view's while something moves or the eye turns.
  double moving_scale = 0.5;
  /// This number of consecutive frames must be equal before an image with all pixels is rendered.
  int still_moments = 4;
  bool in_background = true;
  VolumeRays rays = VolumeRays::kProcessor;
};

/// Planes that cut the patient open.
/// @param cut_mm  Distance from the centre of the box, along the cut's normal.
/// @param towards_eye  Unit, CT space; that side of the plane is removed.
std::vector<volume_rendering::CutPlane> CutsOf(VolumeCut cut, double cut_mm,
                                               const Eigen::AlignedBox3d& box_in_ct_mm,
                                               const Eigen::Vector3d& towards_eye);

class VolumeView {
 public:
  /// @param looks  Must outlive this; empty: there is no such view.
  VolumeView(const std::vector<VolumeLook>& looks, const VolumeViewSettings& settings);

  bool empty() const { return looks_.empty(); }
  /// Takes the newest image, and requests the next one unless this one is up to date.
  /// @param place  Rectangle in the window; empty: not shown, nothing is rendered.
  void Update(const DisplayFrame& frame, const Rectangle& place, const Orbit& orbit,
              const VolumeChoice& choice);
  /// Empty before the first image. It has the proportions of the rectangle that it was rendered
  /// for.
  const image::ColourImage& image() const { return image_; }

  /// "bone, cut axially": for the view's title.
  std::string TitleDetail(const VolumeChoice& choice) const;
  /// Nothing while the view is not shown.
  std::optional<VolumeReadout> readout() const;
  /// Waits for an image that is being rendered. See VolumeRenderer::Wait().
  void Wait();

 private:
  VolumeMoment MomentOf(const DisplayFrame& frame, const Orbit& orbit,
                        const VolumeChoice& choice) const;

  const std::vector<VolumeLook>& looks_;
  VolumeViewSettings settings_;
  std::unique_ptr<VolumeRenderer> renderer_;  ///< Null before the first Update().
  image::ColourImage image_;
  std::optional<VolumeMoment> asked_;
  bool asked_whole_ = false;  ///< Requested with all pixels.
  int same_moments_ = 0;
  bool shown_ = false;
};

}  // namespace acus::window
