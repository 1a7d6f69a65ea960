// What a video camera would see of a mannequin and tools with facets: images for tests and for
// the stand-in devices.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acus/data/mesh/surface.h"
#include "acus/rig/camera/board.h"
#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/facets.h"
#include "acus/rig/camera/image.h"

namespace acus::camera {

struct ObjectInView {
  std::string name;                                                      ///< Of the facet set.
  Eigen::Isometry3d camera_from_object = Eigen::Isometry3d::Identity();  ///< mm.
};

/// A body in the frame of one of the objects, such as the mannequin's skin.
struct BodyInView {
  std::string object;     ///< Which one carries it.
  mesh::Surface surface;  ///< In that object's frame; triangles counter-clockwise from outside.
  Eigen::Array3f colour = {0.80F, 0.62F, 0.52F};  ///< sRGB, 0 to 1.
};

/// How the image is taken. The defaults are those of a plain webcam in a room.
struct ImageMaking {
  int samples = 4;              ///< Each way in a pixel; 1 to 16.
  double blur_sigma_px = 0.7;   ///< Of lens and sensor, Gaussian.
  double noise_sigma = 2.0;     ///< Of each pixel, grey levels of 255.
  double black = 30.0;          ///< Grey level of printed black,
  double white = 215.0;         ///< and of paper, in the middle of the image.
  double light_gradient = 0.2;  ///< Relative change of the light over the image's width.
  bool colour = true;           ///< Otherwise grey.
};

/// A trunk of 340 x 500 x 220 mm along y, with its object's origin on top of it in the middle, z
/// up: for mannequins without a skin surface.
mesh::Surface PlainTorso();

/// Renders by itself; the same input gives the same bits. Not for two threads at a time.
class MannequinCamera {
 public:
  struct Content;

  /// @throws InputError for a setting out of range, or a body of an object that is not in the set.
  MannequinCamera(const CameraModel& camera, FacetSet facets, std::vector<BodyInView> bodies,
                  const ImageMaking& making);
  ~MannequinCamera();
  MannequinCamera(MannequinCamera&&) noexcept;
  MannequinCamera& operator=(MannequinCamera&&) noexcept;

  /// Objects that are not given are not in the image. Bodies hide markers behind them, and nearer
  /// markers hide those behind. `noise_index` picks the noise: give the number of the image.
  /// @throws InputError for an object that is not in the set or a pose that is not finite.
  void Render(std::span<const ObjectInView> objects, std::uint64_t noise_index, Image& out);

 private:
  std::unique_ptr<Content> content_;
};

/// A calibration board before the same background. @throws InputError as MannequinCamera does.
void RenderBoard(const CameraModel& camera, const CalibrationBoard& board,
                 const Eigen::Isometry3d& camera_from_board, const ImageMaking& making,
                 std::uint64_t noise_index, Image& out);

}  // namespace acus::camera
