// Where an object with facets is, from the corners of its markers in an image.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/facets.h"
#include "acus/rig/camera/marker_detector.h"
#include "acus/rig/camera/pose_refinement.h"

namespace acus::camera {

struct ObjectPose {
  std::string name;
  Eigen::Isometry3d camera_from_object = Eigen::Isometry3d::Identity();  ///< mm.
  int corners_used = 0;
  int corners_rejected = 0;  ///< Did not fit the others.
  double rms_px = 0.0;       ///< Of the used corners' residuals.
  /// Covariance of small changes d: camera_from_object * (exp of d). Translation in the camera's
  /// frame first (mm), then rotation about the object's origin along the camera's axes (rad).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Squared residuals of the best other pose, over those of this one: a flat marker seen from far
  /// off has two. Large is clear; 1 is no difference.
  double ambiguity_ratio = 0.0;
  bool ambiguous = false;  ///< The ratio is small, and no earlier pose decides which it is.

  /// Standard deviations along the worst direction, from `covariance`.
  double PositionSigmaMm() const;
  double AngleSigmaDeg() const;
};

struct PoseSettings {
  double largest_residual_px = 2.0;       ///< Corners further off are omitted.
  double smallest_ambiguity_ratio = 2.5;  ///< Below it a pose is ambiguous.
  double corner_sigma_px = 0.03;          ///< Least standard deviation of a corner.
};

/// Nothing if fewer than four corners of the object's markers are there or fit one pose.
/// @param previous  Its pose in the image before, if it was seen: decides between two solutions.
std::optional<ObjectPose> LocateObject(const FacetObject& object,
                                       std::span<const DetectedMarker> markers,
                                       const CameraModel& camera, const PoseSettings& settings,
                                       const std::optional<Eigen::Isometry3d>& previous);

/// The markers that one of several cameras sees.
struct ViewedMarkers {
  Viewpoint viewpoint;
  std::span<const DetectedMarker> markers;
};

/// The same from the images that several cameras took at one moment: the pose, in the first
/// camera's frame, fits the corners of all of them. A corner that only one camera sees counts too.
/// @param starts  Further poses to begin from, besides those of each single marker.
std::optional<ObjectPose> LocateObjectInViews(const FacetObject& object,
                                              std::span<const ViewedMarkers> views,
                                              const PoseSettings& settings,
                                              std::span<const Eigen::Isometry3d> starts,
                                              const std::optional<Eigen::Isometry3d>& previous);

}  // namespace acus::camera
