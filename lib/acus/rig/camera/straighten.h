// Images without the lens: what a pinhole at the same place would have seen.
#pragma once

#include <memory>

#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/image.h"

namespace acus::camera {

/// Straight lines become straight, so that an image rendered with a pinhole lies over the video.
class Straightener {
 public:
  /// Images of `camera` to images of `camera.Pinhole()`, of the same size.
  explicit Straightener(const CameraModel& camera);
  ~Straightener();
  Straightener(Straightener&&) noexcept;
  Straightener& operator=(Straightener&&) noexcept;

  const CameraModel& pinhole() const;
  /// Bilinear; black where the camera did not see. Keeps time and channels. A camera without
  /// distortion: a copy. @throws InputError if the image is not of the camera's size.
  void Straighten(const Image& image, Image& out) const;

 private:
  struct Map;
  std::unique_ptr<Map> map_;
};

}  // namespace acus::camera
