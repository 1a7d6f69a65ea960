#include "acus/rig/camera/opencv_model.h"

#include <opencv2/core.hpp>

namespace acus::camera {

cv::Mat MatrixOf(const CameraModel& camera) {
  const CameraParameters& p = camera.parameters();
  return (cv::Mat_<double>(3, 3) << p.focal_px[0], 0, p.centre_px[0], 0, p.focal_px[1],
          p.centre_px[1], 0, 0, 1);
}

cv::Mat DistortionOf(const CameraModel& camera) {
  const CameraParameters& p = camera.parameters();
  return (cv::Mat_<double>(1, 5) << p.radial[0], p.radial[1], p.tangential[0], p.tangential[1],
          p.radial[2]);
}

cv::Mat TurnOf(const Eigen::Isometry3d& pose) {
  cv::Mat turn(3, 3, CV_64F);
  for (int i = 0; i < 9; ++i) turn.at<double>(i / 3, i % 3) = pose.linear()(i / 3, i % 3);
  return turn;
}

cv::Mat ShiftOf(const Eigen::Isometry3d& pose) {
  cv::Mat shift(3, 1, CV_64F);
  for (int i = 0; i < 3; ++i) shift.at<double>(i) = pose.translation()[i];
  return shift;
}

Eigen::Isometry3d PoseFrom(const cv::Mat& turn, const cv::Mat& shift) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 9; ++i) pose.linear()(i / 3, i % 3) = turn.at<double>(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) pose.translation()[i] = shift.at<double>(i);
  return pose;
}

}  // namespace acus::camera
