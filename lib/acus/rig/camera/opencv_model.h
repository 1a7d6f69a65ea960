// Cameras and poses as OpenCV's functions take them: its types stay out of headers.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "acus/rig/camera/camera_model.h"

namespace cv {
class Mat;
}

namespace acus::camera {

cv::Mat MatrixOf(const CameraModel& camera);      ///< 3 x 3.
cv::Mat DistortionOf(const CameraModel& camera);  ///< k1, k2, p1, p2, k3.
cv::Mat TurnOf(const Eigen::Isometry3d& pose);    ///< 3 x 3.
cv::Mat ShiftOf(const Eigen::Isometry3d& pose);   ///< 3 x 1.
/// From a 3 x 3 rotation and a translation.
Eigen::Isometry3d PoseFrom(const cv::Mat& turn, const cv::Mat& shift);

/// Reads a calibration that OpenCV or ROS wrote as YAML, or OpenCV as XML (.xml): image_width,
/// image_height, camera_matrix and distortion_coefficients (also of other spellings).
/// @throws InputError if a key is missing, a number is not finite, or the lens is of another model
///     than five coefficients describe.
CameraModel ReadOpenCvCamera(const std::filesystem::path& path);

}  // namespace acus::camera
