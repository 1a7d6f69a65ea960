#include "acus/rig/camera/camera_hand_eye.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"

namespace acus::camera {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

const Isometry3d kCameraOnBase =
    Translation3d(12, -35, 60) * AngleAxisd(0.9, Vector3d(1, 2, -1).normalized());
const Isometry3d kBoardOnOther =
    Translation3d(-400, 150, 900) * AngleAxisd(2.8, Vector3d(-1, 0.3, 2).normalized());

struct Pairs {
  std::vector<Isometry3d> body, board;
};

/// Poses of the body, and of the board in the camera by the closed form.
Pairs Made(CameraMount mount, int count, double turn_rad, double noise_mm, bool one_axis = false) {
  RandomStream random(8, "camera hand eye");
  Pairs pairs;
  for (int i = 0; i < count; ++i) {
    const Vector3d axis =
        one_axis ? Vector3d::UnitZ() : Vector3d(random.Normal(), random.Normal(), random.Normal());
    const Isometry3d body =
        Translation3d(50 * Vector3d(random.Normal(), random.Normal(), random.Normal())) *
        AngleAxisd(random.Uniform(-turn_rad, turn_rad), axis.normalized());
    pairs.body.push_back(body);
    const Isometry3d base = mount == CameraMount::kOnBody ? body : body.inverse();
    Isometry3d board = (base * kCameraOnBase).inverse() * kBoardOnOther;
    board.translation() += noise_mm * Vector3d(random.Normal(), random.Normal(), random.Normal());
    pairs.board.push_back(board);
  }
  return pairs;
}

TEST(CalibrateCameraHandEye, IsExactWithoutNoiseForBothMounts) {
  for (const auto mount : {CameraMount::kOnBody, CameraMount::kStanding}) {
    const Pairs pairs = Made(mount, 12, 0.8, 0.0);
    const auto found = CalibrateCameraHandEye(pairs.body, pairs.board, mount, 5.0);
    EXPECT_TRUE(found.base_from_camera.isApprox(kCameraOnBase, 1e-8));
    EXPECT_TRUE(found.other_from_board.isApprox(kBoardOnOther, 1e-8));
    EXPECT_LT(found.rms_mm, 1e-6);
  }
}

TEST(CalibrateCameraHandEye, IsCloseWithNoise) {
  const Pairs pairs = Made(CameraMount::kOnBody, 25, 0.8, 0.3);
  const auto found = CalibrateCameraHandEye(pairs.body, pairs.board, CameraMount::kOnBody, 5.0);
  EXPECT_LT((found.base_from_camera.translation() - kCameraOnBase.translation()).norm(), 1.0);
  EXPECT_NEAR(found.rms_mm, 0.3 * std::sqrt(3.0), 0.15);
}

TEST(CalibrateCameraHandEye, RefusesNonsense) {
  const Pairs one_axis = Made(CameraMount::kOnBody, 12, 0.8, 0.0, true);
  EXPECT_THAT(
      [&] { CalibrateCameraHandEye(one_axis.body, one_axis.board, CameraMount::kOnBody, 5.0); },
      ThrowsMessage<NoAnswerError>(HasSubstr("beside its main axis the body turned by only")));
  Pairs late = Made(CameraMount::kOnBody, 12, 0.8, 0.0);
  std::ranges::rotate(late.board, late.board.begin() + 1);
  EXPECT_THAT([&] { CalibrateCameraHandEye(late.body, late.board, CameraMount::kOnBody, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("the poses are not those of the images")));
  late.board.pop_back();
  EXPECT_THAT([&] { CalibrateCameraHandEye(late.body, late.board, CameraMount::kOnBody, 5.0); },
              ThrowsMessage<InputError>(HasSubstr("12 poses of the body, but 11 images")));
}

}  // namespace
}  // namespace acus::camera
