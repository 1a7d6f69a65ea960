// The eye of the teaching view, moved around the patient.
#pragma once

#include <Eigen/Geometry>
#include <string_view>

#include "acus/imaging/volume_rendering/camera.h"

namespace acus::window {

class Orbit {
 public:
  explicit Orbit(const Eigen::AlignedBox3d& box_in_ct_mm);

  /// 1 anterior, 2 posterior, 3 left, 4 right, 5 superior, 6 inferior, 7 oblique; others: no
  /// change.
  void SetPreset(int number);
  /// Looks obliquely from the patient's side where a tool is, so that it is not seen end-on.
  /// @param place_in_ct_mm  Position of a tool. Within 1 mm of the patient's axis: no change.
  void LookAtSideOf(const Eigen::Vector3d& place_in_ct_mm);
  /// Rotates by the motion of the pointer, in pixels: to the right turns the patient to the right.
  void Turn(double right_px, double down_px);
  void Shift(double right_px, double down_px, int height_px);
  /// Below 1: closer.
  void Zoom(double factor);

  volume_rendering::Camera CameraFor(int width_px, int height_px) const;
  /// One eye of two, `half_base_mm` beside the middle: negative for the left one. Both see the
  /// focus at the same position (parallel axes, shifted images).
  volume_rendering::Camera EyeFor(int width_px, int height_px, double half_base_mm) const;
  double distance_mm() const;
  /// Unit, CT space.
  Eigen::Vector3d TowardsEye() const;
  const Eigen::AlignedBox3d& box_in_ct_mm() const { return box_; }
  double patient_size_mm() const { return box_.diagonal().norm(); }

 private:
  Eigen::AlignedBox3d box_;
  volume_rendering::Viewpoint viewpoint_;
};

}  // namespace acus::window
