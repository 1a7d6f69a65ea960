// The CT over the video: rendered for the video's camera, fading towards the patient's outline.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <memory>
#include <vector>

#include "acus/data/mesh/surface.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::window {

/// Opacity of a pixel that lies `distance_px` inside the outline of the volume's projection:
///   s(d / D), s(t) = t^2 (3 - 2 t), 0 for t <= 0 and 1 for t >= 1, D = falloff_px.
/// The distance falloff of Augmented-2010, section II.A ("pixels become more transparent as they
/// get closer to the 2D projected edge of the volume"), which names no formula.
double EdgeOpacity(double distance_px, double falloff_px) noexcept;

/// Distances of the pixels of `inside` (row by row, 0 is outside) from the nearest outside pixel,
/// in pixels; 0 outside. Pixels beyond the image count as inside.
std::vector<float> DistanceToEdge(const std::vector<std::uint8_t>& inside, int width, int height);

/// Pixels that a surface covers, 255, and others, 0. Triangles behind the eye are omitted.
std::vector<std::uint8_t> SilhouetteOf(const mesh::Surface& surface,
                                       const volume_rendering::Camera& camera);

/// The same camera with another number of pixels over the same field.
volume_rendering::Camera Resampled(const volume_rendering::Camera& camera, int width_px,
                                   int height_px);

/// The largest distance in pixels by which points of the box move from one camera's image to the
/// other's; infinite if one of them is not visible.
double LargestShiftPx(const volume_rendering::Camera& from, const volume_rendering::Camera& to,
                      const Eigen::AlignedBox3d& box_in_ct_mm);

struct OverlayImage {
  volume_rendering::Camera camera;  ///< The camera of the rendering; with its own size in pixels.
  std::vector<std::uint8_t> rgba;
};

struct OverlaySettings {
  double scale = 0.5;           ///< Ratio of its width and height to those of the video, in pixels.
  double falloff_share = 0.10;  ///< In shares of the image's width.
  bool in_background = true;
};

/// Renders overlays one after the other in a separate thread.
class OverlayRenderer {
 public:
  /// @param outline  Its projected edge is used; null or empty: that of the visible layers.
  /// @throws InputError as PatientView does.
  OverlayRenderer(const volume_rendering::PatientInView& patient, const mesh::Surface* outline,
                  const OverlaySettings& settings);
  ~OverlayRenderer();
  OverlayRenderer(const OverlayRenderer&) = delete;
  OverlayRenderer& operator=(const OverlayRenderer&) = delete;

  /// Renders for this camera of the video, unless the newest overlay is for it, or one is being
  /// rendered. @param motion  Copied; null: at rest.
  /// @throws InputError for a camera or motion that cannot be rendered, now or at a later call.
  void Ask(const volume_rendering::Camera& video, const breathing::MotionMap* motion);
  /// True if there is a newer overlay than at the last call; then it is in `out`.
  bool Take(OverlayImage& out);
  /// Waits until no overlay is being rendered.
  void Wait();

  const Eigen::AlignedBox3d& box_in_ct_mm() const;
  long num_rendered() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
