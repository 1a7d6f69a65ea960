// Surfaces and images in space, in a part of a window.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>

#include "acus/data/image/image.h"
#include "acus/data/mesh/surface.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/window/layout.h"

class vtkRenderer;

namespace acus::window {

/// Red, green, blue, opacity by pixel, row 0 at the top.
struct Texture {
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> rgba;
};

/// The appearance of a surface.
struct Look {
  Eigen::Array3f colour = Eigen::Array3f::Ones();  ///< sRGB.
  double opacity = 1.0;  ///< Below 1: to be added after the things behind it.
  bool lit = true;
  bool both_sides = true;  ///< False: visible from outside only.
};

/// The visible range of distances, mm from the eye.
struct DepthRange {
  double near_mm = 20.0;
  double far_mm = 5000.0;
};

/// Things are drawn in the order added, each with a depth test. Transparent ones too: VTK's passes
/// for these cost three times as much without graphics hardware.
class SpaceLayer {
 public:
  SpaceLayer();
  ~SpaceLayer();
  SpaceLayer(const SpaceLayer&) = delete;
  SpaceLayer& operator=(const SpaceLayer&) = delete;

  /// Renderer of an eye; 1 is the right one.
  vtkRenderer* renderer(int eye);

  /// A gradient; without it, the layer below is visible.
  void SetBackground(const Eigen::Array3f& top, const Eigen::Array3f& bottom);
  /// To be called when the renderer is in its window's layer.
  void PaintBackground();
  /// @param towards  Direction of the light, in CT space; a weaker light comes from the eye.
  void SetLight(const Eigen::Vector3d& towards);

  /// The rectangle in the window, and the camera, whose image fills it. An empty rectangle: not
  /// drawn.
  /// @param both_eyes  The window gives each eye its own image (square pixels, the axis in the
  ///     centre of the image).
  void SetView(const Rectangle& place, const Rectangle& window,
               const volume_rendering::Camera& camera, const DepthRange& range,
               bool both_eyes = false);
  /// The view of the right eye beside it; nothing: none.
  void SetRightEye(const Rectangle& place, const Rectangle& window,
                   const std::optional<volume_rendering::Camera>& camera, const DepthRange& range);

  /// Returns the number of the added thing, for the functions below.
  int Add(const mesh::Surface& surface, const Look& look);
  /// @param normals  By node; null: each triangle is flat.
  void SetNodes(int thing, const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xf* normals);
  /// Replaces nodes and triangles.
  void SetSurface(int thing, const mesh::Surface& surface);
  void SetPose(int thing, const Eigen::Isometry3d& ct_from_thing);
  void SetShown(int thing, bool shown);
  void SetOpacity(int thing, double opacity);
  /// @param at  2 x nodes, 0 to 1: in shares of the width and height, from the upper left corner.
  void SetTexturePlaces(int thing, const Eigen::Matrix2Xf& at);
  void SetTexture(int thing, const Texture& texture);
  void SetTexture(int thing, const image::GrayImage& image);

 private:
  struct Thing;
  struct Content;
  std::unique_ptr<Content> content_;
};

/// A surface of at most this number of triangles; unchanged if it has no more.
mesh::Surface Thinned(const mesh::Surface& surface, int max_triangles);

}  // namespace acus::window
