// Two cameras that stand fixed to each other: where the second one is in the first one's frame.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "acus/rig/camera/board_views.h"
#include "acus/rig/camera/camera_model.h"

namespace acus::camera {

struct StereoView {
  std::string left, right;  ///< Files.
  int corners = 0;          ///< Seen by both cameras.
  double rms_px = 0.0;      ///< Of both images.
  std::string rejected;     ///< Why it was not used; empty if it was.
};

struct StereoCalibration {
  Eigen::Isometry3d right_from_left = Eigen::Isometry3d::Identity();
  double rms_px = 0.0;
  double baseline_mm = 0.0;
  std::vector<StereoView> views;
};

/// OpenCV's stereoCalibrate on the corners that both cameras see, the cameras' models held.
/// @param left, right  Images of the same moments, in the same order.
/// @param limit_px     Largest reprojection error (RMS).
/// @throws InputError if the counts differ.
/// @throws NoAnswerError if fewer than 3 pairs show 12 common corners, or residuals are above the
///     limit; the message says what probably happened.
StereoCalibration CalibrateStereo(const BoardViews& left, const BoardViews& right,
                                  const CalibrationBoard& board, const CameraModel& left_camera,
                                  const CameraModel& right_camera, double limit_px);

}  // namespace acus::camera
