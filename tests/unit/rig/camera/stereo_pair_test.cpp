#include "acus/rig/camera/stereo_pair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "support/facet_views.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using namespace testing_support;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Two webcams with their lenses, turned towards each other.
StereoPair ConvergingPair() {
  const CameraModel webcam = ReadCamera(ConfigPath("cameras/webcam_720p.json"));
  return {.left = webcam,
          .right = webcam,
          .right_from_left = Eigen::Translation3d(-150, 4, 12) *
                             Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY())};
}

TEST(StereoPair, TriangulatesPointsThatBothSee) {
  const StereoPair pair = ConvergingPair();
  for (const double z_mm : {400.0, 1000.0, 1500.0}) {
    for (const double x_mm : {-50.0, 30.0, 120.0}) {
      const Eigen::Vector3d point(x_mm, -0.1 * z_mm, z_mm);
      const auto found = Triangulate(pair, *pair.left.Project(point),
                                     *pair.right.Project(pair.right_from_left * point));
      ASSERT_TRUE(found);
      EXPECT_LT((*found - point).norm(), 1e-6);
    }
  }
}

TEST(StereoPair, LinesThatDoNotMeetBeforeBothGiveNoPoint) {
  StereoPair pair = ConvergingPair();
  pair.right_from_left = Eigen::Translation3d(-150, 0, 0);
  const Eigen::Vector3d point(20, 10, 800);
  const Eigen::Vector2d left = *pair.left.Project(point);
  const Eigen::Vector2d right = *pair.right.Project(pair.right_from_left * point);
  ASSERT_TRUE(Triangulate(pair, left, right));
  EXPECT_FALSE(Triangulate(pair, right, left)) << "exchanged: they meet behind the cameras";
  EXPECT_FALSE(Triangulate(pair, left, left)) << "parallel";
}

TEST(StereoPair, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const StereoPair pair = ConvergingPair();
  config::WriteJson(folder / "stereo.json", ToJson(pair));
  const StereoPair read = ReadStereo(folder / "stereo.json");
  EXPECT_TRUE(read.right_from_left.isApprox(pair.right_from_left, 1e-12));
  EXPECT_EQ(read.left.parameters().radial, pair.left.parameters().radial);
  EXPECT_NEAR(ReadStereo(ConfigPath("cameras/micron_pair_2010.json")).BaselineMm(), 120.0, 1e-12);
}

TEST(StereoPair, FilesThatAreNoPairAreRefused) {
  const TemporaryFolder folder;
  const auto expect_refused = [&](const StereoPair& pair, const std::string& why) {
    config::WriteJson(folder / "stereo.json", ToJson(pair));
    EXPECT_THAT([&] { ReadStereo(folder / "stereo.json"); },
                ThrowsMessage<InputError>(HasSubstr(why)));
  };
  StereoPair pair = ConvergingPair();
  pair.right_from_left.translation().setZero();
  expect_refused(pair, "the cameras are 0 mm apart");
  pair.right_from_left.translation().x() = -100.0;
  pair.right_from_left.linear() *= 1.2;
  expect_refused(pair, "/right_from_left: is not a rotation");
  auto document = ToJson(ConvergingPair());
  document["left"].erase("focal_px");
  config::WriteJson(folder / "stereo.json", document);
  EXPECT_THAT([&] { ReadStereo(folder / "stereo.json"); },
              ThrowsMessage<InputError>(HasSubstr("/left")));
}

TEST(StereoPair, AFileOfOtherCamerasIsRefused) {
  const StereoPair pair = ConvergingPair();
  RequireSameCamera(pair.left, pair.left, "left");
  CameraParameters longer = pair.left.parameters();
  longer.focal_px *= 1.01;
  EXPECT_THAT([&] { RequireSameCamera(pair.left, CameraModel(longer), "left"); },
              ThrowsMessage<InputError>(HasSubstr("lines of sight at pixel")));
  const CameraModel small = ReadCamera(ConfigPath("cameras/micron_tracker_2010.json"));
  EXPECT_THAT([&] { RequireSameCamera(pair.left, small, "left"); },
              ThrowsMessage<InputError>(HasSubstr("the stereo file is of other cameras")));
}

}  // namespace
}  // namespace acus::camera
