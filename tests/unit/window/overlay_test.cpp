#include "acus/window/overlay.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "support/view_scenes.h"

namespace acus::window {
namespace {

volume_rendering::Camera SomeCamera() {
  volume_rendering::Camera camera = volume_rendering::LookAt({.eye_in_ct_mm = {30.0, -500.0, 80.0},
                                                              .focus_in_ct_mm = {0.0, 0.0, 0.0},
                                                              .up_in_ct = {0.0, 0.0, 1.0},
                                                              .view_angle_deg = 25.0},
                                                             {.width_px = 320, .height_px = 240});
  camera.centre_px += Eigen::Vector2d(9.0, -5.0);
  return camera;
}

TEST(EdgeOpacity, RisesFromNothingAtTheEdgeToAllAtTheFalloff) {
  EXPECT_EQ(EdgeOpacity(0.0, 20.0), 0.0);
  EXPECT_EQ(EdgeOpacity(-3.0, 20.0), 0.0);
  EXPECT_DOUBLE_EQ(EdgeOpacity(10.0, 20.0), 0.5);
  EXPECT_EQ(EdgeOpacity(20.0, 20.0), 1.0);
  EXPECT_EQ(EdgeOpacity(std::numeric_limits<double>::infinity(), 20.0), 1.0);
  EXPECT_EQ(EdgeOpacity(0.5, 0.0), 1.0) << "no falloff";
  for (double d = 0.0; d < 20.0; d += 0.5) {
    EXPECT_LT(EdgeOpacity(d, 20.0), EdgeOpacity(d + 0.5, 20.0)) << d;
  }
}

TEST(DistanceToEdge, IsThatFromADiscsRim) {
  constexpr int kSize = 81;
  std::vector<std::uint8_t> inside(kSize * kSize, 0);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      inside[static_cast<std::size_t>(y * kSize + x)] =
          std::hypot(x - 40.0, y - 40.0) <= 30.0 ? 255 : 0;
    }
  }
  const auto distance = DistanceToEdge(inside, kSize, kSize);
  for (int x = 0; x < kSize; ++x) {
    const double expected = std::max(0.0, 31.0 - std::abs(x - 40.0));
    EXPECT_NEAR(distance[static_cast<std::size_t>(40 * kSize + x)], expected, 1.0) << x;
  }
  EXPECT_EQ(distance[0], 0.0F);
}

TEST(DistanceToEdge, TheImagesBorderIsNoEdge) {
  EXPECT_TRUE(std::isinf(DistanceToEdge(std::vector<std::uint8_t>(12, 255), 4, 3)[0]));
}

TEST(Silhouette, CoversWhatTheBallProjectsTo) {
  const volume_rendering::Camera camera = SomeCamera();
  const Eigen::Vector3d centre(10.0, 20.0, -15.0);
  const double radius = 40.0;
  const auto mask = SilhouetteOf(testing_support::BallSurface(centre, radius), camera);
  int wrong = 0;
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Eigen::Vector3d eye = camera.EyeInCtMm();
      const Eigen::Vector3d along = camera.DirectionInCt(Eigen::Vector2d(x, y)).normalized();
      const double off = (centre - eye - (centre - eye).dot(along) * along).norm();
      const bool in_ball = off < radius;
      const bool in_mask = mask[static_cast<std::size_t>(y * camera.width_px + x)] != 0;
      wrong += in_ball != in_mask && std::abs(off - radius) > 2.5 ? 1 : 0;  // 2.5 mm: two pixels.
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Resampled, PixelsStayWhereTheyAre) {
  const volume_rendering::Camera camera = SomeCamera();
  const volume_rendering::Camera half = Resampled(camera, 160, 120);
  const Eigen::Vector3d place(25.0, 10.0, -30.0);
  const Eigen::Vector2d whole_px = camera.ProjectPx(place);
  const Eigen::Vector2d half_px = half.ProjectPx(place);
  EXPECT_NEAR((half_px[0] + 0.5) / 160.0, (whole_px[0] + 0.5) / 320.0, 1e-12);
  EXPECT_NEAR((half_px[1] + 0.5) / 120.0, (whole_px[1] + 0.5) / 240.0, 1e-12);
}

TEST(LargestShift, IsThatOfTheFarthestMovedCorner) {
  const volume_rendering::Camera camera = SomeCamera();
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-50.0), Eigen::Vector3d::Constant(50.0));
  EXPECT_EQ(LargestShiftPx(camera, camera, box), 0.0);
  volume_rendering::Camera moved = camera;
  moved.centre_px[0] += 3.0;
  EXPECT_NEAR(LargestShiftPx(camera, moved, box), 3.0, 1e-9);
  volume_rendering::Camera away = camera;
  away.camera_from_ct = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitY()) * camera.camera_from_ct;
  EXPECT_TRUE(std::isinf(LargestShiftPx(camera, away, box)));
}

class Overlay : public ::testing::TestWithParam<bool> {
 protected:
  static volume_rendering::PatientInView Ball() {
    volume_rendering::PatientInView patient;
    patient.ct = testing_support::BallCt({0, 0, 0}, 40.0);
    patient.layers = {{"skin", 1.0}};
    return patient;
  }
};

TEST_P(Overlay, IsRenderedOnceForAStillCameraAndAgainForAMovedOne) {
  OverlayRenderer overlay(Ball(), nullptr,
                          {.scale = 0.5, .falloff_share = 0.05, .in_background = GetParam()});
  const volume_rendering::Camera camera = SomeCamera();
  OverlayImage image;
  EXPECT_FALSE(overlay.Take(image));
  for (int i = 0; i < 5; ++i) {
    overlay.Ask(camera, nullptr);
    overlay.Wait();
  }
  EXPECT_EQ(overlay.num_rendered(), 1);
  ASSERT_TRUE(overlay.Take(image));
  EXPECT_FALSE(overlay.Take(image)) << "only the first time";
  EXPECT_EQ(image.camera.width_px, 160);
  volume_rendering::Camera moved = camera;
  moved.camera_from_ct = Eigen::Translation3d(4.0, 0.0, 0.0) * camera.camera_from_ct;
  overlay.Ask(moved, nullptr);
  overlay.Wait();
  EXPECT_EQ(overlay.num_rendered(), 2);
}

TEST_P(Overlay, FadesTowardsTheOutline) {
  OverlayRenderer overlay(Ball(), nullptr,
                          {.scale = 1.0, .falloff_share = 0.06, .in_background = GetParam()});
  volume_rendering::Camera camera = SomeCamera();
  overlay.Ask(camera, nullptr);
  overlay.Wait();
  OverlayImage image;
  ASSERT_TRUE(overlay.Take(image));
  const Eigen::Vector2i middle = camera.ProjectPx(Eigen::Vector3d::Zero()).cast<int>();
  const std::uint8_t* skin =
      &image.rgba[4 * static_cast<std::size_t>(middle[1] * camera.width_px + middle[0])];
  EXPECT_GT(skin[0], skin[1]) << "red before green";
  EXPECT_GT(skin[1], skin[2]) << "green before blue";
  int before = 255;
  int faded = 0;
  for (int x = middle[0]; x < camera.width_px; ++x) {
    const int opacity =
        image.rgba[4 * static_cast<std::size_t>(middle[1] * camera.width_px + x) + 3];
    EXPECT_LE(opacity, before + 3) << "column " << x;
    faded += opacity > 10 && opacity < 240 ? 1 : 0;
    before = opacity;
  }
  EXPECT_EQ(before, 0);
  EXPECT_GE(faded, 10) << "the rim is about 19 pixels wide";
}

TEST_P(Overlay, SaysWhatItCannotRender) {
  OverlayRenderer overlay(Ball(), nullptr,
                          {.scale = 0.5, .falloff_share = 0.05, .in_background = GetParam()});
  volume_rendering::Camera camera = SomeCamera();
  camera.focal_px.setZero();
  const auto ask = [&] {
    overlay.Ask(camera, nullptr);
    overlay.Wait();
    overlay.Ask(camera, nullptr);
  };
  EXPECT_THROW(ask(), InputError);
}

INSTANTIATE_TEST_SUITE_P(InBackgroundOrNot, Overlay, ::testing::Bool());

}  // namespace
}  // namespace acus::window
