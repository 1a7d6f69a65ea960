// A camera on a tracked body, and a board on another: where the camera sits on its body.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/camera/board_views.h"
#include "acus/rig/camera/camera_model.h"

namespace acus::camera {

enum class CameraMount {
  kOnBody,   ///< The camera is fixed to the tracked body, the board stands still.
  kStanding  ///< The camera stands still, the board is fixed to the tracked body.
};

struct CameraHandEye {
  /// kOnBody: body_from_camera; kStanding: reference_from_camera.
  Eigen::Isometry3d base_from_camera = Eigen::Isometry3d::Identity();
  /// kOnBody: reference_from_board; kStanding: body_from_board.
  Eigen::Isometry3d other_from_board = Eigen::Isometry3d::Identity();
  double rms_mm = 0.0;              ///< Of the board's origin about its mean place.
  double rms_deg = 0.0;             ///< The same of its angle.
  double turn_deg = 0.0;            ///< How far the body turned about its second axis, RMS.
  std::vector<double> residual_mm;  ///< One per pair.
};

/// The pose of the board in an image: OpenCV's solvePnP with the camera's lens.
/// @throws NoAnswerError if there are fewer than 6 corners.
Eigen::Isometry3d BoardPose(const std::vector<BoardCorner>& corners, const CalibrationBoard& board,
                            const CameraModel& camera);

/// Solves A X = X B over all motions between pairs (OpenCV's calibrateHandEye by the method of Park
/// and Martin 1994, doi:10.1109/70.326576).
/// @param reference_from_body  From the tracker, at the instant of each image.
/// @param camera_from_board    Of each image.
/// @param limit_mm  Largest RMS of the residuals.
/// @throws InputError if the counts differ or there are fewer than 5 pairs.
/// @throws NoAnswerError if the body turned too little, or the residuals are above the limit.
CameraHandEye CalibrateCameraHandEye(std::span<const Eigen::Isometry3d> reference_from_body,
                                     std::span<const Eigen::Isometry3d> camera_from_board,
                                     CameraMount mount, double limit_mm);

}  // namespace acus::camera
