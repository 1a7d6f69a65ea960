// Where an image of the patient is taken from: a pinhole camera.
#pragma once

#include <Eigen/Geometry>
#include <string_view>

namespace acus::volume_rendering {

/// The camera's frame has x to the right, y down and z forward; centres of pixels are at whole
/// numbers. That is how calibrated video cameras are described, so that images fit over video.
struct Camera {
  Eigen::Isometry3d camera_from_ct = Eigen::Isometry3d::Identity();
  Eigen::Vector2d focal_px = Eigen::Vector2d::Ones();
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< Where z meets the image.
  int width_px = 0;
  int height_px = 0;

  Eigen::Vector3d EyeInCtMm() const { return camera_from_ct.inverse().translation(); }
  /// Column and row of a point in CT space. @pre It lies before the camera.
  Eigen::Vector2d ProjectPx(const Eigen::Vector3d& point_in_ct_mm) const;
  /// In CT space, one mm along z for its length: not a unit vector.
  Eigen::Vector3d DirectionInCt(const Eigen::Vector2d& pixel) const;
  /// The same view with `factor` times as many pixels each way.
  Camera Magnified(int factor) const;

  /// @throws InputError unless the size is 1 to 8192 each way, the focal lengths are positive, and
  ///     all is finite.
  void Check() const;
};

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

struct Viewpoint {
  Eigen::Vector3d eye_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d focus_in_ct_mm = Eigen::Vector3d::UnitY();
  Eigen::Vector3d up_in_ct = Eigen::Vector3d::UnitZ();
  double view_angle_deg = 30.0;  ///< Over the height of the image.
};

/// @throws InputError if the eye is at the focus, `up` runs along the line of sight, the angle is
///     not within (0, 150), or the size is not as Camera::Check wants it.
Camera LookAt(const Viewpoint& viewpoint, const ImageSize& size);

/// A box in CT space from one side, all of it in the image.
/// @param side  "anterior", "posterior", "left", "right", "superior", "inferior", or "oblique":
///     from in front, the patient's right and above.
/// @throws InputError for another side, or an empty box.
Viewpoint ViewFrom(std::string_view side, const Eigen::AlignedBox3d& box_in_ct_mm,
                   const ImageSize& size, double view_angle_deg = 30.0);

}  // namespace acus::volume_rendering
