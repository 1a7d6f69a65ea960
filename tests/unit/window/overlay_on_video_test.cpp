// The CT over the video: where its places are seen.
#include <gtest/gtest.h>

#include "acus/window/image_layer.h"
#include "support/window_input.h"
#include "support/window_scene.h"

namespace acus::window {
namespace {

/// Bright balls at known places of a CT. The overlay of the video must show them where the video's
/// camera sees these places.
class OverlayOnVideo : public WindowTest {
 protected:
  static const std::vector<Eigen::Vector3d>& Places() {
    static const std::vector<Eigen::Vector3d> places = {
        {-60, -20, -50}, {55, 30, -45}, {0, 0, 0}, {-50, 40, 60}, {65, -45, 55}, {20, 60, -10}};
    return places;
  }
  static PatientOnDisplay Markers() {
    volume::Geometry grid;
    grid.size = {170, 150, 150};
    grid.spacing_mm.setConstant(1.0);
    grid.origin_mm = {-85, -75, -75};
    auto ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{-1000});
    const Eigen::Affine3d ct_from_index = grid.ct_from_index();
    for (int k = 0; k < 150; ++k) {
      for (int j = 0; j < 150; ++j) {
        for (int i = 0; i < 170; ++i) {
          const Eigen::Vector3d at = ct_from_index * Eigen::Vector3d(i, j, k);
          for (const Eigen::Vector3d& place : Places()) {
            if ((at - place).squaredNorm() < 16.0) ct->At(i, j, k) = 1500;
          }
        }
      }
    }
    PatientOnDisplay patient;
    patient.in_overlay.ct = ct;
    patient.in_overlay.layers = {{"bone", 1.0}};
    return patient;
  }
  static WindowSettings WithoutFalloff(double scale) {
    WindowSettings settings = Settings();
    settings.edge_falloff_share = 0.0;
    settings.overlay_scale = scale;
    return settings;
  }
  /// The largest distance of a marker from its projection, in pixels of the video.
  static double WorstPx(Window& window, const DisplayFrame& frame) {
    const Shot shot = ShotOf(window, frame);
    const Rectangle place = VideoPlace(window);
    const double px_per_video_px = place.width / 640.0;
    double worst = 0.0;
    for (const Eigen::Vector3d& at : Places()) {
      const Eigen::Vector2d expected = OnScreen(place, frame.video->camera.ProjectPx(at));
      const Eigen::Vector2d seen = shot.MiddleNear(expected, 12, 40);
      EXPECT_TRUE(seen.allFinite()) << "no marker near " << expected.transpose();
      worst = std::max(worst, (seen - expected).norm() / px_per_video_px);
    }
    return worst;
  }
  static DisplayFrame OnlyVideo() {
    DisplayFrame frame;
    frame.video = Video();
    return frame;
  }
};

TEST_F(OverlayOnVideo, MarkersFallOnTheirProjections) {
  for (const double scale : {1.0, 0.5}) {
    Window window(Markers(), WithoutFalloff(scale));
    const double worst = WorstPx(window, OnlyVideo());
    EXPECT_LT(worst, 1.0) << "pixels; 2 are allowed; overlay at scale " << scale;
    RecordProperty(scale == 1.0 ? "full_px" : "half_px", std::to_string(worst));
    EXPECT_EQ(window.num_overlays(), 1) << "the camera is still";
  }
}

TEST_F(OverlayOnVideo, FollowsTheCamera) {
  Window window(Markers(), WithoutFalloff(0.5));
  DisplayFrame frame = OnlyVideo();
  window.Show(frame);
  frame.video->camera.camera_from_ct =
      Eigen::Translation3d(12.0, -7.0, 30.0) *
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.3, 1.0, 0.2).normalized()) *
      frame.video->camera.camera_from_ct;
  EXPECT_LT(WorstPx(window, frame), 1.0);
  EXPECT_GE(window.num_overlays(), 2);
}

TEST_F(OverlayOnVideo, TheOldOneMovesAlongUntilTheNewOneIsThere) {
  WindowSettings settings = WithoutFalloff(0.5);
  settings.overlay_in_background = true;
  Window window(Markers(), settings);
  DisplayFrame frame = OnlyVideo();
  ASSERT_TRUE(ShowUntil(window, frame, [&] { return window.num_overlays() > 0; }));
  window.Show(frame);
  // The patient's marker at 30 cm/s for the 0.1 s of an overlay: 30 mm across, 1 degree about.
  const auto still = frame.video->camera;
  frame.video->camera.camera_from_ct = Eigen::Translation3d(30.0, 0.0, 0.0) * still.camera_from_ct *
                                       Eigen::AngleAxisd(0.017, Eigen::Vector3d::UnitZ());
  window.Show(frame);
  const Shot shot{window.Screenshot()};
  const Rectangle place = VideoPlace(window);
  for (const Eigen::Vector3d& at : Places()) {
    const Eigen::Vector2d expected = OnScreen(place, frame.video->camera.ProjectPx(at));
    const double shift = (expected - OnScreen(place, still.ProjectPx(at))).norm();
    const Eigen::Vector2d seen = shot.MiddleNear(expected, 14, 40);
    EXPECT_LT((seen - expected).norm(), 0.3 * shift) << "moved " << shift << " pixels";
  }
}

TEST_F(OverlayOnVideo, TheVideosLensIsTakenOut) {
  Window window(Markers(), WithoutFalloff(1.0));
  DisplayFrame frame = OnlyVideo();
  frame.video->pose_valid = false;  // No overlay: what is seen is the video.
  frame.video->distortion = {-0.25, 0.08, 0.001, -0.0015, 0.0};
  std::vector<Eigen::Vector2d> places;
  for (int x = 80; x <= 560; x += 120) {
    for (int y = 60; y <= 420; y += 120) {
      const Eigen::Vector2d pinhole(x, y);
      const Eigen::Vector2d bent = Distorted(pinhole, frame.video->camera, frame.video->distortion);
      places.push_back(pinhole);
      for (int r = -4; r <= 4; ++r) {
        for (int c = -4; c <= 4; ++c) {
          const Eigen::Vector2i at = (bent + Eigen::Vector2d(c, r)).array().round().cast<int>();
          const double light =
              255.0 * std::clamp(3.5 - (at.cast<double>() - bent).norm(), 0.0, 1.0);
          for (int k = 0; k < 3; ++k) {
            frame.video->image.rgb[static_cast<std::size_t>(3 * (at[1] * 640 + at[0]) + k)] =
                static_cast<std::uint8_t>(light);
          }
        }
      }
    }
  }
  const Shot shot = ShotOf(window, frame);
  const Rectangle place = VideoPlace(window);
  for (const Eigen::Vector2d& pinhole : places) {
    const Eigen::Vector2d expected = OnScreen(place, pinhole);
    const Eigen::Vector2d seen = shot.MiddleNear(expected, 10, 30);
    EXPECT_LT((seen - expected).norm() * 640.0 / place.width, 0.5) << pinhole.transpose();
  }
}

TEST_F(OverlayOnVideo, TheSliderGoesFromVideoToCt) {
  Window window(Markers(), WithoutFalloff(1.0));
  testing_support::WindowInput input;
  DisplayFrame frame = OnlyVideo();
  const auto brightness = [&] {
    const Shot shot = ShotOf(window, frame);
    return shot.Count(VideoPlace(window), [](int r, int, int) { return r > 60; });
  };
  const int first = brightness();
  EXPECT_GT(first, 100);
  for (int i = 0; i < 10; ++i) input.Key("O");
  ASSERT_TRUE(ShowUntil(window, frame, [&] {
    return std::ranges::count(window.TakeCommands(), Command::kOverlayLess) > 0;
  }));
  ASSERT_TRUE(ShowUntil(window, frame, [&] { return brightness() == 0; })) << "the video is black";
}

}  // namespace
}  // namespace acus::window
