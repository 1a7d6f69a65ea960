#include "acus/rig/camera/facet_pose.h"

#include <gtest/gtest.h>

#include "support/facet_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

/// What a perfect detector would see.
std::vector<DetectedMarker> PerfectCorners(const FacetObject& object, const CameraModel& camera,
                                           const Eigen::Isometry3d& pose) {
  std::vector<DetectedMarker> seen;
  for (const Marker& marker : object.markers) {
    DetectedMarker detected{
        .id = marker.id, .corners_px = {}, .sigma_px = {0.02, 0.02, 0.02, 0.02}};
    for (std::size_t k = 0; k < 4; ++k) {
      detected.corners_px[k] = *camera.Project(pose * marker.CornersInObjectMm()[k]);
    }
    seen.push_back(detected);
  }
  return seen;
}

class FacetPose : public testing::Test {
 protected:
  CameraModel camera_ = ReadCamera(ConfigPath("cameras/webcam_720p.json"));
  FacetSet set_ = ReadFacets(ConfigPath("facets/training.json"));
  Eigen::Isometry3d truth_ = FacingPose({40, 30, 900}, 25, 130, 60);
};

TEST_F(FacetPose, PerfectCornersGiveThePose) {
  for (const FacetObject& object : set_.objects) {
    const auto seen = PerfectCorners(object, camera_, truth_);
    const auto pose = LocateObject(object, seen, camera_, {}, std::nullopt);
    ASSERT_TRUE(pose);
    EXPECT_EQ(pose->name, object.name);
    const PoseError error = ErrorOf(pose->camera_from_object, truth_);
    EXPECT_LT(error.position_mm, 1e-5);
    EXPECT_LT(error.angle_deg, 1e-5);
    EXPECT_LT(pose->rms_px, 1e-6);
    EXPECT_FALSE(pose->ambiguous);
    EXPECT_EQ(pose->corners_rejected, 0);
  }
}

TEST_F(FacetPose, WrongCornersAreExcludedAndCounted) {
  auto seen = PerfectCorners(set_.objects[0], camera_, truth_);
  seen[1].corners_px[2] += Eigen::Vector2d(3, 1);
  seen[6].corners_px[0] += Eigen::Vector2d(-40, 25);
  const auto pose = LocateObject(set_.objects[0], seen, camera_, {}, std::nullopt);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->corners_rejected, 2);
  EXPECT_EQ(pose->corners_used, 30);
  EXPECT_LT(ErrorOf(pose->camera_from_object, truth_).position_mm, 1e-4);
}

TEST_F(FacetPose, SheetsThatAreElsewhereGiveNoPose) {
  // Every marker shows a pose of its own.
  std::vector<DetectedMarker> seen;
  for (std::size_t m = 0; m < 8; ++m) {
    const double turn = 40.0 * static_cast<double>(m);
    const auto alone = PerfectCorners(set_.objects[0], camera_,
                                      FacingPose({-200.0 + turn, turn - 100, 900}, 20, turn, turn));
    seen.push_back(alone[m]);
  }
  EXPECT_FALSE(LocateObject(set_.objects[0], seen, camera_, {}, std::nullopt));
}

TEST_F(FacetPose, MarkersOfOthersDoNotCount) {
  const auto seen = PerfectCorners(set_.objects[0], camera_, truth_);
  EXPECT_FALSE(LocateObject(set_.objects[1], seen, camera_, {}, std::nullopt));
  EXPECT_FALSE(LocateObject(set_.objects[0], {}, camera_, {}, std::nullopt));
}

TEST_F(FacetPose, CornersOnALineOrInAPointGiveNoPose) {
  DetectedMarker flat{.id = 0, .corners_px = {}, .sigma_px = {0.02, 0.02, 0.02, 0.02}};
  for (std::size_t k = 0; k < 4; ++k) flat.corners_px[k] = {600.0, 300.0};
  const auto in_a_point =
      LocateObject(OneMarker(40).objects[0], std::vector{flat}, camera_, {}, {});
  if (in_a_point) {
    EXPECT_GT(in_a_point->PositionSigmaMm(), 100.0);
  }
  for (std::size_t k = 0; k < 4; ++k)
    flat.corners_px[k] = {600.0 + 10.0 * static_cast<double>(k), 300};
  const auto on_a_line = LocateObject(OneMarker(40).objects[0], std::vector{flat}, camera_, {}, {});
  if (on_a_line) {
    EXPECT_GT(on_a_line->rms_px, 1.0);
  }
}

TEST_F(FacetPose, SpreadGrowsWithThatOfTheCorners) {
  auto seen = PerfectCorners(set_.objects[0], camera_, truth_);
  const auto fine = LocateObject(set_.objects[0], seen, camera_, {}, std::nullopt);
  for (DetectedMarker& marker : seen) marker.sigma_px.fill(0.5);
  const auto coarse = LocateObject(set_.objects[0], seen, camera_, {}, std::nullopt);
  ASSERT_TRUE(fine && coarse);
  const double ratio = std::hypot(0.5, 0.03) / std::hypot(0.02, 0.03);
  EXPECT_NEAR(coarse->PositionSigmaMm() / fine->PositionSigmaMm(), ratio, 0.01 * ratio);
  EXPECT_NEAR(coarse->AngleSigmaDeg() / fine->AngleSigmaDeg(), ratio, 0.01 * ratio);
}

}  // namespace
}  // namespace acus::camera
