// Images in a window: video, ultrasound, slices.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/window/layout.h"

class vtkRenderer;

namespace acus::window {

/// Positions are pixels of the window from its upper left corner.
class ImageLayer {
 public:
  ImageLayer();
  ~ImageLayer();
  ImageLayer(const ImageLayer&) = delete;
  ImageLayer& operator=(const ImageLayer&) = delete;

  vtkRenderer* renderer();
  void SetWindowSize(int width_px, int height_px);

  /// Scaled to fill the rectangle.
  void Show(ViewKind view, const image::GrayImage& image, const Rectangle& place);
  void Show(ViewKind view, const image::ColourImage& image, const Rectangle& place);
  /// Without the lens's distortion (Brown's k1, k2, p1, p2, k3): as the pinhole of `camera` would
  /// see it. Pixels outside the lens's image are black.
  void Show(const image::ColourImage& image, const volume_rendering::Camera& camera,
            const std::array<double, 5>& distortion, const Rectangle& place);
  void Hide(ViewKind view);

 private:
  void Show(ViewKind view, int width, int height, int components,
            const std::vector<std::uint8_t>& pixels, const Rectangle& place);

  struct Content;
  std::unique_ptr<Content> content_;
};

/// The position under Brown's distortion of the point at `pixel` of a pinhole camera.
Eigen::Vector2d Distorted(const Eigen::Vector2d& pixel, const volume_rendering::Camera& camera,
                          const std::array<double, 5>& distortion);

}  // namespace acus::window
