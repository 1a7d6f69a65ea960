#include "acus/rig/camera/stereo.h"

#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>

#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_model.h"

namespace acus::camera {
namespace {

constexpr std::size_t kLeastStereoPairs = 3;
constexpr std::size_t kLeastCommonCorners = 12;

struct PairCorners {
  std::vector<cv::Point3f> on_board;
  std::vector<cv::Point2f> left, right;
};

cv::Point2f PointOf(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel[0]), static_cast<float>(pixel[1])};
}

PairCorners CommonCorners(const BoardView& left, const BoardView& right,
                          const std::vector<Eigen::Vector3d>& on_board) {
  std::map<std::size_t, Eigen::Vector2d> seen;
  for (const BoardCorner& corner : left.corners) seen[corner.number] = corner.pixel;
  PairCorners common;
  for (const BoardCorner& corner : right.corners) {
    const auto found = seen.find(corner.number);
    if (found == seen.end()) continue;
    const Eigen::Vector3f at = on_board[corner.number].cast<float>();
    common.on_board.emplace_back(at[0], at[1], at[2]);
    common.left.push_back(PointOf(found->second));
    common.right.push_back(PointOf(corner.pixel));
  }
  return common;
}

void RequireSize(const BoardViews& views, const CameraModel& camera, const char* side) {
  const CameraParameters& p = camera.parameters();
  ACUS_REQUIRE(views.width_px == p.width_px && views.height_px == p.height_px, "the ", side,
               " images have ", views.width_px, " x ", views.height_px,
               " pixels, the camera's file says ", p.width_px, " x ", p.height_px);
}

}  // namespace

StereoCalibration CalibrateStereo(const BoardViews& left, const BoardViews& right,
                                  const CalibrationBoard& board, const CameraModel& left_camera,
                                  const CameraModel& right_camera, double limit_px) {
  ACUS_REQUIRE(left.views.size() == right.views.size(), "there are ", left.views.size(),
               " images of the left camera, but ", right.views.size(),
               " of the right; both need one of each moment, in the same order");
  RequireSize(left, left_camera, "left");
  RequireSize(right, right_camera, "right");
  StereoCalibration out;
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> in_left, in_right;
  std::vector<std::size_t> view_of;
  for (std::size_t i = 0; i < left.views.size(); ++i) {
    StereoView& view = out.views.emplace_back();
    view.left = left.views[i].file;
    view.right = right.views[i].file;
    PairCorners common = CommonCorners(left.views[i], right.views[i], board.CornersMm());
    view.corners = static_cast<int>(common.on_board.size());
    if (common.on_board.size() < kLeastCommonCorners) {
      view.rejected = Message("only ", view.corners, " corners are seen by both cameras; ",
                              kLeastCommonCorners, " are needed");
      continue;
    }
    on_board.push_back(std::move(common.on_board));
    in_left.push_back(std::move(common.left));
    in_right.push_back(std::move(common.right));
    view_of.push_back(i);
  }
  if (view_of.size() < kLeastStereoPairs) {
    throw NoAnswerError(Message("only ", view_of.size(), " pairs of images show ",
                                kLeastCommonCorners, " common corners of the board, ",
                                kLeastStereoPairs,
                                " are needed: hold it where both cameras see it"));
  }
  cv::Mat left_matrix = MatrixOf(left_camera), left_lens = DistortionOf(left_camera);
  cv::Mat right_matrix = MatrixOf(right_camera), right_lens = DistortionOf(right_camera);
  cv::Mat turn, shift, essential, fundamental, view_rms;
  try {
    out.rms_px = cv::stereoCalibrate(
        on_board, in_left, in_right, left_matrix, left_lens, right_matrix, right_lens,
        {left.width_px, left.height_px}, turn, shift, essential, fundamental, view_rms,
        cv::CALIB_FIX_INTRINSIC, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10});
  } catch (const cv::Exception& error) {
    throw NoAnswerError("the stereo calibration failed (" + error.err +
                        "); take pairs of images of the board at more different angles");
  }
  for (std::size_t i = 0; i < view_of.size(); ++i) {
    const auto row = static_cast<int>(i);
    out.views[view_of[i]].rms_px =
        std::hypot(view_rms.at<double>(row, 0), view_rms.at<double>(row, 1)) / std::sqrt(2.0);
  }
  out.right_from_left = PoseFrom(turn, shift);
  out.baseline_mm = out.right_from_left.translation().norm();
  if (out.rms_px > limit_px) {
    throw NoAnswerError(Message(
        "the corners are ", out.rms_px,
        " px RMS from where one pair of cameras puts them "
        "(allowed: ",
        limit_px,
        " px, --limit-px): probably the images are not of the same moments, "
        "left and right are exchanged in some, a camera moved, or a camera's file is of another "
        "camera"));
  }
  return out;
}

}  // namespace acus::camera
