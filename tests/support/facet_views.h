// Images of facets whose pose is known.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"
#include "acus/rig/camera/facet_pose.h"
#include "acus/rig/camera/mannequin_camera.h"

namespace acus::testing_support {

inline std::string ConfigPath(const std::string& name) {
  return ACUS_SOURCE_DIR "/configs/" + name;
}

/// An object before the camera that shows it its +z side (z of the object towards the camera, y up
/// in the image), turned by `tilt` about an axis in the image plane at `azimuth`, and rolled.
inline Eigen::Isometry3d FacingPose(const Eigen::Vector3d& at_mm, double tilt_deg,
                                    double azimuth_deg, double roll_deg) {
  const double rad = std::numbers::pi / 180.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis(std::cos(azimuth_deg * rad), std::sin(azimuth_deg * rad), 0.0);
  pose.linear() = (Eigen::AngleAxisd(tilt_deg * rad, axis) *
                   Eigen::AngleAxisd(roll_deg * rad, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = at_mm;
  return pose;
}

/// One flat square marker on "Reference".
inline camera::FacetSet OneMarker(double side_mm, int id = 0,
                                  const std::string& dictionary = "apriltag_36h11") {
  camera::Marker marker;
  marker.id = id;
  marker.side_mm = side_mm;
  marker.facet = "sheet";
  return {.name = "one marker",
          .dictionary = dictionary,
          .objects = {{.name = "Reference", .markers = {marker}}}};
}

struct PoseError {
  double position_mm;
  double angle_deg;
};

/// Of the point `about` of the object.
inline PoseError ErrorOf(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth,
                         const Eigen::Vector3d& about = Eigen::Vector3d::Zero()) {
  return {.position_mm = (found * about - truth * about).norm(),
          .angle_deg = math::AngleBetweenRad(found, truth) * 180.0 / std::numbers::pi};
}

}  // namespace acus::testing_support
