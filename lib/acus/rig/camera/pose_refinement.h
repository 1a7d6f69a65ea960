// A pose from points of known place and where they are seen: least squares that bear outliers.
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "acus/rig/camera/camera_model.h"

namespace acus::camera {

/// One of the cameras that look at an object at the same moment. Poses are found in the frame of
/// the first one.
struct Viewpoint {
  const CameraModel* camera = nullptr;
  Eigen::Isometry3d here_from_first = Eigen::Isometry3d::Identity();
};

struct SeenPoint {
  Eigen::Vector3d in_object_mm;
  Eigen::Vector2d pixel;
  double sigma_px;            ///< Standard deviation along each axis, above 0.
  std::size_t viewpoint = 0;  ///< Which camera sees it.
};

struct RefinedPose {
  Eigen::Isometry3d camera_from_object = Eigen::Isometry3d::Identity();
  /// Sum of min((residual / sigma)^2, cap) over all points.
  double cost = 0.0;
  /// Inverse of the weighted normal matrix: translation in the first camera's frame (mm), then
  /// rotation about the object's origin along the camera's axes (rad).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  bool converged = false;
};

/// Squared distance from where a point is seen, over its variance; `cap` if it is not seen at all.
double SquaredResidual(const SeenPoint& point, const Eigen::Isometry3d& camera_from_object,
                       std::span<const Viewpoint> viewpoints, double cap);

/// Levenberg-Marquardt with Geman-McClure's weights: a residual of `outlier_sigmas` standard
/// deviations counts a quarter, further ones next to nothing. With several cameras this is their
/// bundle adjustment, the cameras held.
RefinedPose RefinePose(std::span<const SeenPoint> points, const Eigen::Isometry3d& start,
                       std::span<const Viewpoint> viewpoints, double outlier_sigmas);

}  // namespace acus::camera
