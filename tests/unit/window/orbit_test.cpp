#include "acus/window/orbit.h"

#include <gtest/gtest.h>

#include "acus/window/image_layer.h"

namespace acus::window {
namespace {

const Eigen::AlignedBox3d kBox(Eigen::Vector3d(-150, -100, 0), Eigen::Vector3d(150, 100, 300));
const Eigen::Vector3d kMiddle = kBox.center();

TEST(Orbit, PresetsLookFromTheirSides) {
  Orbit orbit(kBox);
  const std::array<Eigen::Vector3d, 6> from{
      Eigen::Vector3d(0, -1, 0), {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
  for (int i = 0; i < 6; ++i) {
    orbit.SetPreset(i + 1);
    const Eigen::Vector3d way = (orbit.CameraFor(640, 400).EyeInCtMm() - kMiddle).normalized();
    EXPECT_NEAR((way - from[static_cast<std::size_t>(i)]).norm(), 0.0, 1e-9) << i + 1;
  }
  const Eigen::Vector3d before = orbit.CameraFor(640, 400).EyeInCtMm();
  orbit.SetPreset(0);
  orbit.SetPreset(8);
  EXPECT_EQ(orbit.CameraFor(640, 400).EyeInCtMm(), before);
}

TEST(Orbit, LooksAtTheSideOfAPlaceAndStaysIfItHasNone) {
  Orbit orbit(kBox);
  for (const Eigen::Vector3d& out :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 1, 0)}) {
    orbit.LookAtSideOf(kMiddle + 120.0 * out + Eigen::Vector3d(0, 0, 80));
    const Eigen::Vector3d way = (orbit.CameraFor(640, 400).EyeInCtMm() - kMiddle).normalized();
    EXPECT_GT(way.dot(out), 0.7);
    EXPECT_GT(way.z(), 0.0) << "from above";
  }
  const Eigen::Vector3d before = orbit.CameraFor(640, 400).EyeInCtMm();
  orbit.LookAtSideOf(kMiddle + Eigen::Vector3d(0, 0, 90));
  EXPECT_EQ(orbit.CameraFor(640, 400).EyeInCtMm(), before) << "a place on the axis has no side";
  orbit.LookAtSideOf(Eigen::Vector3d::Constant(std::nan("")));
  EXPECT_EQ(orbit.CameraFor(640, 400).EyeInCtMm(), before);
}

TEST(Orbit, TheWholePatientIsInTheImageAlsoWhereItIsNarrow) {
  Orbit orbit(kBox);
  for (int preset = 1; preset <= 7; ++preset) {
    orbit.SetPreset(preset);
    for (const auto& [width, height] : {std::pair{1280, 700}, {640, 700}, {300, 700}}) {
      const volume_rendering::Camera camera = orbit.CameraFor(width, height);
      for (int c = 0; c < 8; ++c) {
        const Eigen::Vector2d at =
            camera.ProjectPx(kBox.corner(static_cast<Eigen::AlignedBox3d::CornerType>(c)));
        EXPECT_GE(at[0], -0.02 * width) << preset;
        EXPECT_LE(at[0], 1.02 * width) << preset;
        EXPECT_GE(at[1], 0) << preset;
        EXPECT_LE(at[1], height) << preset;
      }
    }
  }
}

TEST(Orbit, TurningKeepsDistanceAndFocusAndBringsBackWhatItTook) {
  Orbit orbit(kBox);
  const volume_rendering::Camera before = orbit.CameraFor(640, 400);
  const double distance = orbit.distance_mm();
  orbit.Turn(120.0, 0.0);
  EXPECT_NEAR(orbit.distance_mm(), distance, 1e-9);
  EXPECT_NEAR((orbit.CameraFor(640, 400).ProjectPx(kMiddle) - before.ProjectPx(kMiddle)).norm(),
              0.0, 1e-6);
  // What is in front moves the way that the pointer does.
  const Eigen::Vector3d in_front = kMiddle + 0.1 * (before.EyeInCtMm() - kMiddle);
  EXPECT_GT(orbit.CameraFor(640, 400).ProjectPx(in_front)[0], before.ProjectPx(in_front)[0] + 5.0);
  orbit.Turn(-120.0, 0.0);
  EXPECT_NEAR((orbit.CameraFor(640, 400).EyeInCtMm() - before.EyeInCtMm()).norm(), 0.0, 1e-6);
  for (int i = 0; i < 300; ++i) orbit.Turn(7.0, 11.0);
  EXPECT_NEAR(orbit.distance_mm(), distance, 1e-6) << "no drift";
}

TEST(Orbit, ShiftingMovesThePatientWithThePointer) {
  Orbit orbit(kBox);
  const Eigen::Vector2d before = orbit.CameraFor(640, 400).ProjectPx(kMiddle);
  orbit.Shift(30.0, -20.0, 400);
  const Eigen::Vector2d after = orbit.CameraFor(640, 400).ProjectPx(kMiddle);
  EXPECT_NEAR(after[0] - before[0], 30.0, 0.5);
  EXPECT_NEAR(after[1] - before[1], -20.0, 0.5);
}

TEST(Orbit, ZoomStaysWithinBounds) {
  Orbit orbit(kBox);
  for (int i = 0; i < 200; ++i) orbit.Zoom(0.5);
  EXPECT_GT(orbit.distance_mm(), 10.0);
  for (int i = 0; i < 200; ++i) orbit.Zoom(2.0);
  EXPECT_LT(orbit.distance_mm(), 1e4);
}

TEST(Orbit, BothEyesSeeTheFocusAtOnePlaceAndWhatIsNearerApart) {
  const Orbit orbit(kBox);
  const volume_rendering::Camera left = orbit.EyeFor(640, 400, -15.0);
  const volume_rendering::Camera right = orbit.EyeFor(640, 400, 15.0);
  EXPECT_NEAR((left.ProjectPx(kMiddle) - right.ProjectPx(kMiddle)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((right.EyeInCtMm() - left.EyeInCtMm()).norm(), 30.0, 1e-9);
  const Eigen::Vector3d nearer = kMiddle + 0.2 * (orbit.CameraFor(640, 400).EyeInCtMm() - kMiddle);
  EXPECT_GT(left.ProjectPx(nearer)[0], right.ProjectPx(nearer)[0] + 2.0);
}

TEST(Distorted, IsBrownsModel) {
  volume_rendering::Camera camera;
  camera.focal_px = {600.0, 610.0};
  camera.centre_px = {320.0, 240.0};
  const Eigen::Vector2d pixel(520.0, 390.0);
  EXPECT_EQ(Distorted(pixel, camera, {}), pixel);
  const double x = 200.0 / 600.0;
  const double y = 150.0 / 610.0;
  const double r2 = x * x + y * y;
  const Eigen::Vector2d bent = Distorted(pixel, camera, {-0.2, 0.05, 0.001, -0.002, 0.01});
  const double s = 1.0 - 0.2 * r2 + 0.05 * r2 * r2 + 0.01 * r2 * r2 * r2;
  EXPECT_NEAR(bent[0], 320.0 + 600.0 * (s * x + 0.002 * x * y - 0.002 * (r2 + 2.0 * x * x)), 1e-9);
  EXPECT_NEAR(bent[1], 240.0 + 610.0 * (s * y + 0.001 * (r2 + 2.0 * y * y) - 0.004 * x * y), 1e-9);
}

}  // namespace
}  // namespace acus::window
