// What the images of the mannequin are painted on, before lens blur and noise.
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "acus/data/mesh/surface.h"
#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/facets.h"

namespace acus::camera {

struct Canvas {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  std::vector<float> level;  ///< As Image::pixels: grey levels of 255, not yet rounded.
  std::vector<float> z_mm;   ///< Of what is seen in each pixel, in the camera's frame.

  void Resize(int new_width_px, int new_height_px, int new_channels);
  std::size_t Pixel(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
           static_cast<std::size_t>(column);
  }
};

/// Lines of sight of all pixels, and between them by interpolation: the lens is smooth, so that
/// half a pixel away this is right to 1e-5 px.
class RayTable {
 public:
  explicit RayTable(const CameraModel& camera);
  /// (x, y) of the ray (x, y, 1), within half a pixel of the image.
  Eigen::Vector2d Slope(double column, double row) const;

 private:
  int width_px_, height_px_;
  std::vector<Eigen::Vector2d> slopes_;
};

/// A body with one normal for each node, ready to be painted.
struct ShadedBody {
  mesh::Surface surface;
  Eigen::Matrix3Xd normals;
  Eigen::Array3f colour;  ///< Grey levels of 255.
};
/// @throws InputError for a surface with a node that is not finite or a triangle of unknown nodes.
ShadedBody PrepareBody(const mesh::Surface& surface, const Eigen::Array3f& srgb);

/// Paints triangles that face the camera and are wholly in front of it, nearest first.
void PaintBody(const ShadedBody& body, const Eigen::Isometry3d& camera_from_body,
               const CameraModel& camera, Canvas& canvas);

/// Black and white squares on paper, origin in the middle, x to the right and y up as printed. Seen
/// from behind it is blank.
struct PrintedSheet {
  double module_mm = 1.0;               ///< Side of a square.
  double margin_mm = 0.0;               ///< White paper around them.
  std::vector<std::vector<bool>> bits;  ///< bits[row][column], row 0 at the top; true is white.
};
/// A marker with its black border and a margin of one module.
PrintedSheet PrintMarker(const std::string& dictionary, int id, double side_mm);

struct Ink {
  float black = 0.0F;
  float white = 255.0F;
  int samples = 4;  ///< Each way in a pixel.
};
void PaintSheet(const PrintedSheet& sheet, const Eigen::Isometry3d& camera_from_sheet,
                const Ink& ink, const CameraModel& camera, const RayTable& rays, Canvas& canvas);

}  // namespace acus::camera
