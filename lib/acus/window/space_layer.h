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

/// What a surface looks like.
struct Look {
  Eigen::Array3f colour = Eigen::Array3f::Ones();  ///< sRGB.
  double opacity = 1.0;  ///< Below 1: to be added after what is to shine through.
  bool lit = true;
  bool both_sides = true;  ///< False: seen from outside only.
};

/// Nearest and furthest that is seen, mm from the eye.
struct DepthRange {
  double near_mm = 20.0;
  double far_mm = 5000.0;
};

/// Things are drawn in the order added, each over what is there where it is nearer. Transparent
/// ones too: VTK's own passes for these cost three times as much without graphics hardware.
class SpaceLayer {
 public:
  SpaceLayer();
  ~SpaceLayer();
  SpaceLayer(const SpaceLayer&) = delete;
  SpaceLayer& operator=(const SpaceLayer&) = delete;

  /// The second is for the right eye.
  vtkRenderer* renderer(int eye);

  /// A gradient; without it, what is behind shines through.
  void SetBackground(const Eigen::Array3f& top, const Eigen::Array3f& bottom);
  /// To be called when it is in its window's layer.
  void PaintBackground();
  /// @param towards  In CT space, where the light comes from; a weaker one comes from the eye.
  void SetLight(const Eigen::Vector3d& towards);

  /// Where in the window, and the camera, whose image fills that. An empty place: not drawn.
  /// @param both_eyes  The window gives each eye its own image (square pixels, the axis in the
  ///     middle of the image).
  void SetView(const Rectangle& place, const Rectangle& window,
               const volume_rendering::Camera& camera, const DepthRange& range,
               bool both_eyes = false);
  /// The right eye beside it; nothing: none.
  void SetRightEye(const Rectangle& place, const Rectangle& window,
                   const std::optional<volume_rendering::Camera>& camera, const DepthRange& range);

  /// Gives the number of the thing added, for the calls below.
  int Add(const mesh::Surface& surface, const Look& look);
  /// @param normals  Of the nodes; null: each triangle is flat.
  void SetNodes(int thing, const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xf* normals);
  /// Other triangles too.
  void SetSurface(int thing, const mesh::Surface& surface);
  void SetPose(int thing, const Eigen::Isometry3d& ct_from_thing);
  void SetShown(int thing, bool shown);
  void SetOpacity(int thing, double opacity);
  /// @param at  2 x nodes, 0 to 1: shares of the width and height, from the upper left corner.
  void SetTexturePlaces(int thing, const Eigen::Matrix2Xf& at);
  void SetTexture(int thing, const Texture& texture);
  void SetTexture(int thing, const image::GrayImage& image);

 private:
  struct Thing;
  struct Content;
  std::unique_ptr<Content> content_;
};

/// A surface of at most so many triangles; as it is if it has no more.
mesh::Surface Thinned(const mesh::Surface& surface, int max_triangles);

}  // namespace acus::window
