#include "acus/rig/camera/camera_hand_eye.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/angles.h"
#include "acus/base/math/rigid.h"
#include "acus/rig/camera/opencv_model.h"

namespace acus::camera {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kLeastPairs = 5;
constexpr double kLeastTurnDeg = 5.0;

/// RMS turn about the second axis of all turns between poses, degrees.
double SecondTurnDeg(std::span<const Isometry3d> poses) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const Isometry3d& from : poses) {
    for (const Isometry3d& to : poses) {
      const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
      const Vector3d v = turn.angle() * turn.axis();
      scatter += v * v.transpose();
    }
  }
  scatter /= static_cast<double>(poses.size() * poses.size());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[1])) / math::kRadPerDegree;
}

/// Chordal mean of the rotations, mean of the translations.
Isometry3d MeanPose(const std::vector<Isometry3d>& poses) {
  Matrix3d rotation = Matrix3d::Zero();
  Vector3d translation = Vector3d::Zero();
  for (const Isometry3d& pose : poses) {
    rotation += pose.linear();
    translation += pose.translation();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  Isometry3d mean = Isometry3d::Identity();
  mean.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  mean.translation() = translation / static_cast<double>(poses.size());
  return mean;
}

Isometry3d SolveByOpenCv(const std::vector<Isometry3d>& base_from_gripper,
                         std::span<const Isometry3d> camera_from_board) {
  std::vector<cv::Mat> gripper_turns, gripper_shifts, board_turns, board_shifts;
  for (std::size_t i = 0; i < base_from_gripper.size(); ++i) {
    gripper_turns.push_back(TurnOf(base_from_gripper[i]));
    gripper_shifts.push_back(ShiftOf(base_from_gripper[i]));
    board_turns.push_back(TurnOf(camera_from_board[i]));
    board_shifts.push_back(ShiftOf(camera_from_board[i]));
  }
  cv::Mat turn, shift;
  try {
    cv::calibrateHandEye(gripper_turns, gripper_shifts, board_turns, board_shifts, turn, shift,
                         cv::CALIB_HAND_EYE_PARK);
  } catch (const cv::Exception& error) {
    throw NoAnswerError("the hand-eye calibration failed (" + error.err +
                        "); turn the body about two different axes between the images");
  }
  return PoseFrom(turn, shift);
}

}  // namespace

Isometry3d BoardPose(const std::vector<BoardCorner>& corners, const CalibrationBoard& board,
                     const CameraModel& camera) {
  if (corners.size() < 6) {
    throw NoAnswerError(Message("only ", corners.size(), " corners of the board; 6 are needed"));
  }
  const auto on_board = board.CornersMm();
  std::vector<cv::Point3d> from;
  std::vector<cv::Point2d> to;
  for (const BoardCorner& corner : corners) {
    const Vector3d& at = on_board[corner.number];
    from.emplace_back(at[0], at[1], at[2]);
    to.emplace_back(corner.pixel[0], corner.pixel[1]);
  }
  cv::Mat turn, shift, matrix;
  cv::solvePnP(from, to, MatrixOf(camera), DistortionOf(camera), turn, shift);
  cv::Rodrigues(turn, matrix);
  return PoseFrom(matrix, shift);
}

CameraHandEye CalibrateCameraHandEye(std::span<const Isometry3d> reference_from_body,
                                     std::span<const Isometry3d> camera_from_board,
                                     CameraMount mount, double limit_mm) {
  ACUS_REQUIRE(reference_from_body.size() == camera_from_board.size(), "there are ",
               reference_from_body.size(), " poses of the body, but ", camera_from_board.size(),
               " images; each image needs its pose, in the same order");
  ACUS_REQUIRE(reference_from_body.size() >= kLeastPairs, "at least ", kLeastPairs,
               " images of the board with their poses are needed, got ",
               reference_from_body.size());
  // A camera that stands still is one on the reference, which moves with the body's inverse pose.
  std::vector<Isometry3d> base_from_gripper;
  for (const Isometry3d& pose : reference_from_body) {
    base_from_gripper.push_back(mount == CameraMount::kOnBody ? pose : pose.inverse());
  }
  CameraHandEye out;
  out.turn_deg = std::min(SecondTurnDeg(base_from_gripper), SecondTurnDeg(camera_from_board));
  if (out.turn_deg < kLeastTurnDeg) {
    throw NoAnswerError(Message("beside its main axis the body turned by only ", out.turn_deg,
                                " deg, at least ", kLeastTurnDeg,
                                " deg are needed; turn it about two different axes"));
  }
  out.base_from_camera = SolveByOpenCv(base_from_gripper, camera_from_board);
  std::vector<Isometry3d> boards;
  for (std::size_t i = 0; i < base_from_gripper.size(); ++i) {
    boards.push_back(base_from_gripper[i] * out.base_from_camera * camera_from_board[i]);
  }
  out.other_from_board = MeanPose(boards);
  double shift2 = 0.0, turn2 = 0.0;
  for (const Isometry3d& board : boards) {
    const double shift_mm = (board.translation() - out.other_from_board.translation()).norm();
    const double turn_deg =
        math::AngleBetweenRad(board, out.other_from_board) / math::kRadPerDegree;
    out.residual_mm.push_back(shift_mm);
    shift2 += shift_mm * shift_mm;
    turn2 += turn_deg * turn_deg;
  }
  out.rms_mm = std::sqrt(shift2 / static_cast<double>(boards.size()));
  out.rms_deg = std::sqrt(turn2 / static_cast<double>(boards.size()));
  if (out.rms_mm > limit_mm) {
    throw NoAnswerError(Message(
        "the board's place varies by ", out.rms_mm, " mm and ", out.rms_deg, " deg RMS over ",
        boards.size(), " images (allowed: ", limit_mm,
        " mm, --limit-mm): probably the poses are not those of the images (order, or a lag between "
        "the clocks), the board or the marker moved, or camera and board are exchanged "
        "(--standing)"));
  }
  return out;
}

}  // namespace acus::camera
