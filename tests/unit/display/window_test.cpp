// A real window under a virtual X server.
#include "display/window.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <thread>

#include "core/error.h"
#include "display/marks.h"
#include "display/picture_layer.h"
#include "support/view_scenes.h"
#include "support/virtual_display.h"
#include "support/window_events.h"
#include "support/window_input.h"

namespace acus::display {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kTitle = "Acus window test";

/// A screenshot with places in it.
struct Shot {
  ultrasound::ColourImage image;

  Eigen::Array3i At(int column, int row) const {
    const auto at = 3 * static_cast<std::size_t>(row * image.width + column);
    return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
  }
  /// Number of pixels for which test(r, g, b).
  template <typename Test>
  int Count(const Rectangle& place, const Test& test) const {
    int count = 0;
    for (int row = place.top; row < place.top + place.height; ++row) {
      for (int column = place.left; column < place.left + place.width; ++column) {
        const Eigen::Array3i c = At(column, row);
        count += test(c[0], c[1], c[2]) ? 1 : 0;
      }
    }
    return count;
  }
  /// Middle of what is brighter than a level, within some pixels of a place. How bright does not
  /// count: light falls on a ball from one side.
  Eigen::Vector2d MiddleNear(const Eigen::Vector2d& place, int reach, int level) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weights = 0.0;
    const Eigen::Vector2i at = place.array().round().cast<int>();
    for (int row = at[1] - reach; row <= at[1] + reach; ++row) {
      for (int column = at[0] - reach; column <= at[0] + reach; ++column) {
        if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
        const double weight = At(column, row).maxCoeff() > level ? 1.0 : 0.0;
        sum += weight * Eigen::Vector2d(column + 0.5, row + 0.5);
        weights += weight;
      }
    }
    return weights > 0.0 ? Eigen::Vector2d(sum / weights)
                         : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
};

bool IsYellow(int r, int g, int b) {
  return r > 200 && g > 160 && b < 140 && r - b > 90;
}
bool IsCyan(int r, int g, int b) {
  return g > 160 && b > 170 && r < 150;
}
bool IsRed(int r, int g, int b) {
  return r > 190 && g < 130 && b < 120;
}

ultrasound::GrayImage Grey(int width, int height, int level) {
  ultrasound::GrayImage image;
  image.Resize(width, height);
  std::ranges::fill(image.pixels, static_cast<std::uint8_t>(level));
  return image;
}

ultrasound::Probe Linear() {
  ultrasound::Probe probe = ultrasound::DefaultProbe();
  probe.name = "test probe";
  probe.kind = ultrasound::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.width_mm = 40.0;
  probe.depth_mm = 50.0;
  probe.image_width_px = probe.image_height_px = 200;
  return probe;
}

class WindowTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    display_ = std::make_unique<testing_support::VirtualDisplay>(1280, 800);
  }
  static void TearDownTestSuite() { display_.reset(); }

  /// A ball of a patient, a probe over it, a needle towards the target.
  static PatientOnDisplay Patient() {
    PatientOnDisplay patient;
    const auto add = [&](const char* name, double radius, Eigen::Array3f colour, double opacity) {
      patient.in_teaching_view.push_back(
          {.name = name,
           .surface = testing_support::BallSurface({0, 0, 0}, radius, 24),
           .colour = colour,
           .opacity = opacity});
    };
    add("skin", 100.0, {0.8F, 0.6F, 0.5F}, 0.3);
    add("bone", 40.0, {0.9F, 0.9F, 0.8F}, 1.0);
    return patient;
  }
  static DisplayFrame Frame() {
    DisplayFrame frame;
    const auto probe = std::make_shared<ultrasound::Probe>(Linear());
    const auto picture = ultrasound::PictureOf(*probe);
    frame.ultrasound.picture = Grey(picture.width_px, picture.height_px, 60);
    frame.ultrasound.probe = probe;
    frame.ct_slice = Grey(picture.width_px, picture.height_px, 120);
    frame.fluoroscopy = Grey(128, 128, 180);
    frame.ct_from_probe = Eigen::Isometry3d(Eigen::Translation3d(0.0, -100.0, 0.0));
    frame.target_in_ct_mm = Eigen::Vector3d(5.0, -75.0, 0.0);
    frame.needle.emplace();
    frame.needle->tip_in_ct_mm = {-8.0, -85.0, 0.0};
    frame.needle->axis_in_ct = Eigen::Vector3d(13.0, 10.0, 0.0).normalized();
    frame.needle->length_mm = 120.0;
    frame.needle->radius_mm = 0.5;
    frame.video = Video();
    frame.status = {{.severity = Severity::kGood, .text = "All tools are seen."}};
    return frame;
  }
  static VideoPicture Video() {
    VideoPicture video;
    video.picture.Resize(640, 480);
    std::ranges::fill(video.picture.rgb, std::uint8_t{0});
    video.camera = rendering::LookAt({.eye_in_ct_mm = {60.0, -480.0, 90.0},
                                      .focus_in_ct_mm = {0.0, 0.0, 0.0},
                                      .up_in_ct = {0.0, 0.0, 1.0},
                                      .view_angle_deg = 30.0},
                                     {.width_px = 640, .height_px = 480});
    video.camera.focal_px[1] *= 1.03;  // As of a real camera: not square, not in the middle.
    video.camera.centre_px += Eigen::Vector2d(17.0, -11.0);
    video.pose_valid = true;
    return video;
  }
  static WindowSettings Settings() {
    WindowSettings settings;
    settings.title = kTitle;
    settings.overlay_in_background = false;
    settings.overlay_scale = 1.0;
    return settings;
  }
  static Shot ShotOf(Window& window, const DisplayFrame& frame) {
    window.Show(frame);
    window.Show(frame);
    return {window.Screenshot()};
  }
  /// Sends what `act` does and shows pictures until `done`, some seconds at most.
  template <typename Done>
  static bool ShowUntil(Window& window, const DisplayFrame& frame, const Done& done) {
    for (int i = 0; i < 200; ++i) {
      window.Show(frame);
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  static Rectangle VideoPlace(const Window& window) {
    const Layout layout = window.layout();
    const TextSizes sizes = SizesFor(layout.status.top + layout.status.height);
    return Fit(PictureRoom(ViewKind::kVideo, layout.Find(ViewKind::kVideo)->place, sizes), 640,
               480);
  }
  /// From a pixel of the video to one of the window; centres of the window's are at halves.
  static Eigen::Vector2d OnScreen(const Rectangle& place, const Eigen::Vector2d& pixel) {
    return {place.left + (pixel[0] + 0.5) * place.width / 640.0,
            place.top + (pixel[1] + 0.5) * place.height / 480.0};
  }

  static std::unique_ptr<testing_support::VirtualDisplay> display_;
};

std::unique_ptr<testing_support::VirtualDisplay> WindowTest::display_;

TEST_F(WindowTest, EveryViewShowsItsPicture) {
  Window window(Patient(), Settings());
  const DisplayFrame frame = Frame();
  const Shot shot = ShotOf(window, frame);
  ASSERT_EQ(shot.image.width, 1280);
  ASSERT_EQ(shot.image.height, 800);
  const Layout layout = window.layout();
  ASSERT_EQ(layout.views.size(), 5U);
  const auto grey_share = [&](ViewKind view, int level) {
    const Rectangle& place = layout.Find(view)->place;
    const int count = shot.Count(place, [&](int r, int g, int b) {
      return std::abs(r - level) <= 2 && std::abs(g - level) <= 2 && std::abs(b - level) <= 2;
    });
    return static_cast<double>(count) / (place.width * place.height);
  };
  EXPECT_GT(grey_share(ViewKind::kUltrasound, 60), 0.25);
  EXPECT_GT(grey_share(ViewKind::kCtSlice, 120), 0.3);
  EXPECT_GT(grey_share(ViewKind::kFluoroscopy, 180), 0.3);
  const Rectangle& teaching = layout.Find(ViewKind::kTeaching)->place;
  EXPECT_GT(shot.Count(teaching, [](int r, int g, int b) { return r > 120 && r > b && g > 60; }),
            1000)
      << "bone";
  for (const Layout::View& view : layout.views) {
    Rectangle title = view.place;
    title.height = 24;
    title.width = 90;
    EXPECT_GT(shot.Count(title, [](int r, int, int) { return r > 190; }), 30)
        << "title of " << TitleOf(view.kind);
  }
}

TEST_F(WindowTest, WhatIsNotThereLeavesItsPlaceToTheOthers) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  frame.video.reset();
  frame.fluoroscopy = {};
  window.Show(frame);
  EXPECT_EQ(window.layout().views.size(), 3U);
  EXPECT_EQ(window.layout().Find(ViewKind::kVideo), nullptr);
  Window empty({}, Settings());
  empty.Show({});
  EXPECT_TRUE(empty.layout().views.empty());
}

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
            frame.video->picture.rgb[static_cast<std::size_t>(3 * (at[1] * 640 + at[0]) + k)] =
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

TEST_F(WindowTest, NeedleAndTargetAreMarkedWhereTheyAre) {
  Window window(Patient(), Settings());
  const DisplayFrame frame = Frame();
  const Shot shot = ShotOf(window, frame);
  const Rectangle video = VideoPlace(window);
  const auto around = [](const Eigen::Vector2d& at) {
    return Rectangle{.left = static_cast<int>(at[0]) - 11,
                     .top = static_cast<int>(at[1]) - 11,
                     .width = 23,
                     .height = 23};
  };
  const auto& camera = frame.video->camera;
  EXPECT_GT(shot.Count(around(OnScreen(video, camera.ProjectPx(*frame.target_in_ct_mm))), IsYellow),
            40);
  const Eigen::Vector3d on_shaft = frame.needle->tip_in_ct_mm - 60.0 * frame.needle->axis_in_ct;
  EXPECT_GT(shot.Count(around(OnScreen(video, camera.ProjectPx(on_shaft))), IsCyan), 20);
  // In the ultrasound picture: probe x and depth, at their scale.
  const Layout layout = window.layout();
  const auto picture = ultrasound::PictureOf(*frame.ultrasound.probe);
  const Rectangle place = Fit(
      PictureRoom(ViewKind::kUltrasound, layout.Find(ViewKind::kUltrasound)->place, SizesFor(800)),
      picture.width_px * picture.lateral_mm_per_px, picture.height_px * picture.axial_mm_per_px);
  const double px_per_mm = place.width / (picture.width_px * picture.lateral_mm_per_px);
  const Eigen::Vector2d target(place.left + 0.5 * place.width + px_per_mm * 5.0,
                               place.top + px_per_mm * 25.0);
  EXPECT_GT(shot.Count(around(target), IsYellow), 40);
}

TEST_F(WindowTest, KeysThroughTheXServerBecomeCommands) {
  Window window(Patient(), Settings());
  testing_support::WindowInput input;
  const DisplayFrame frame = Frame();
  window.Show(frame);
  std::vector<Command> got;
  const auto press = [&](const char* key, Command expected) {
    input.Key(key);
    got.clear();
    return ShowUntil(window, frame, [&] {
      for (const Command command : window.TakeCommands()) got.push_back(command);
      return std::ranges::find(got, expected) != got.end();
    });
  };
  for (const auto& [key, command] : {std::pair{"f", Command::kFreeze},
                                     {"g", Command::kGainUp},
                                     {"G", Command::kGainDown},
                                     {"d", Command::kDeeper},
                                     {"D", Command::kShallower},
                                     {"t", Command::kMarkTarget},
                                     {"b", Command::kHoldBreath},
                                     {"w", Command::kSwapHands},
                                     {"n", Command::kNeedleGuide},
                                     {"Tab", Command::kSteerOther},
                                     {"5", Command::kCameraPreset}}) {
    EXPECT_TRUE(press(key, command)) << key;
  }
  EXPECT_TRUE(press("v", Command::kNextView));
  EXPECT_EQ(window.layout().views.size(), 1U);
  EXPECT_TRUE(press("a", Command::kGrid));
  input.Key("q");
  EXPECT_TRUE(press("q", Command::kQuit));
}

TEST_F(WindowTest, TheHelpPageLiesOverTheViews) {
  Window window(Patient(), Settings());
  testing_support::WindowInput input;
  const DisplayFrame frame = Frame();
  window.Show(frame);
  const Rectangle middle{.left = 480, .top = 150, .width = 300, .height = 400};
  const auto is_text = [](int r, int g, int b) {
    return r > 150 && std::abs(r - b) < 25 && g > 150;
  };
  const int before = ShotOf(window, frame).Count(middle, is_text);
  input.Key("h");
  EXPECT_TRUE(ShowUntil(window, frame, [&] {
    const Shot shot{window.Screenshot()};
    return shot.Count(middle, [](int r, int g, int b) { return r < 30 && g < 35 && b < 40; }) >
               80000 &&
           shot.Count(middle, is_text) > before / 2 + 1000;
  }));
}

TEST_F(WindowTest, TheMouseTurnsThe3dViewAndMovesTheTool) {
  Window window(Patient(), Settings());
  testing_support::WindowInput input;
  const DisplayFrame frame = Frame();
  const Shot before = ShotOf(window, frame);
  const Layout layout = window.layout();
  const auto drag = [&](ViewKind view) {
    const Rectangle& place = layout.Find(view)->place;
    input.Point(place.left + 60, place.top + 80);
    window.Show(frame);
    input.ButtonDown(1);
    input.Point(place.left + 100, place.top + 80);
    input.ButtonUp(1);
  };
  drag(ViewKind::kTeaching);
  const Rectangle& place = layout.Find(ViewKind::kTeaching)->place;
  EXPECT_TRUE(ShowUntil(window, frame, [&] {
    const Shot now{window.Screenshot()};
    int changed = 0;
    for (int row = place.top; row < place.top + place.height; ++row) {
      for (int column = place.left; column < place.left + place.width; ++column) {
        changed += (now.At(column, row) - before.At(column, row)).abs().maxCoeff() > 20 ? 1 : 0;
      }
    }
    return changed > 300;
  })) << "the probe is seen from elsewhere";
  EXPECT_EQ(window.TakeHandInput().moved_mm.norm(), 0.0);
  drag(ViewKind::kUltrasound);
  EXPECT_TRUE(ShowUntil(window, frame, [&] { return window.TakeHandInput().moved_mm[0] > 1.0; }));
}

TEST_F(WindowTest, ThePedalIsUpWhenTheKeyIs) {
  Window window(Patient(), Settings());
  testing_support::WindowInput input;
  const DisplayFrame frame = Frame();
  window.Show(frame);
  input.KeyDown("space");
  EXPECT_TRUE(ShowUntil(window, frame, [&] { return window.TakeHandInput().pedal; }));
  for (int i = 0; i < 5; ++i) {
    window.Show(frame);
    EXPECT_TRUE(window.TakeHandInput().pedal) << "it stays down";
  }
  input.KeyUp("space");
  EXPECT_TRUE(ShowUntil(window, frame, [&] { return !window.TakeHandInput().pedal; }));
}

TEST_F(WindowTest, FaultsAreRedInTheBarAndFrozenPicturesSaySo) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  Rectangle lines = LayOut(1280, 800, {}, {}).status;
  lines.width = 700;
  EXPECT_EQ(ShotOf(window, frame).Count(lines, IsRed), 0);
  frame.status.push_back({.severity = Severity::kFault,
                          .text = "The tracker does not see the needle: forces are off."});
  EXPECT_GT(ShotOf(window, frame).Count(lines, IsRed), 300);
  const Rectangle ultrasound = window.layout().Find(ViewKind::kUltrasound)->place;
  const auto is_amber = [](int r, int g, int b) {
    return r > 180 && g > 120 && g < 200 && b < 110;
  };
  const int before = ShotOf(window, frame).Count(ultrasound, is_amber);
  frame.ultrasound.frozen = true;
  EXPECT_GT(ShotOf(window, frame).Count(ultrasound, is_amber), before + 800);
}

TEST_F(WindowTest, StereoShowsTwoEyes) {
  Window window(Patient(), Settings());
  testing_support::WindowInput input;
  DisplayFrame frame;
  frame.needle = Frame().needle;
  window.Show(frame);
  input.Key("s");
  ASSERT_TRUE(ShowUntil(window, frame, [&] { return !window.TakeCommands().empty(); }));
  Shot shot = ShotOf(window, frame);
  int differ = 0;
  int alike = 0;
  for (int row = 100; row < 600; ++row) {
    for (int column = 40; column < 600; ++column) {
      const int by = (shot.At(column, row) - shot.At(column + 641, row)).abs().maxCoeff();
      (by > 12 ? differ : alike) += 1;
    }
  }
  EXPECT_GT(differ, 200) << "what is nearer is elsewhere";
  EXPECT_GT(alike, 10 * differ) << "else it is the same scene";
  input.Key("s");
  ASSERT_TRUE(ShowUntil(window, frame, [&] { return !window.TakeCommands().empty(); }));
  shot = ShotOf(window, frame);
  const Rectangle all{.left = 0, .top = 40, .width = 1280, .height = 600};
  EXPECT_GT(shot.Count(all, [](int r, int g, int b) { return r > b + 40 && r > g + 40; }), 200);
  EXPECT_GT(shot.Count(all, [](int r, int g, int b) { return g > r + 40 && b > r + 30; }), 200);
}

TEST_F(WindowTest, FollowsItsSize) {
  Window window(Patient(), Settings());
  const DisplayFrame frame = Frame();
  window.Show(frame);
  ASSERT_TRUE(testing_support::ResizeWindow(kTitle, 900, 620));
  EXPECT_TRUE(ShowUntil(window, frame, [&] {
    const Layout layout = window.layout();
    return layout.status.width == 900 && layout.status.top + layout.status.height == 620;
  }));
  const Shot shot = ShotOf(window, frame);
  EXPECT_EQ(shot.image.width, 900);
  const Rectangle place = window.layout().Find(ViewKind::kFluoroscopy)->place;
  EXPECT_GT(shot.Count(place, [](int r, int, int) { return std::abs(r - 180) <= 2; }),
            place.width * place.height / 4);
  ASSERT_TRUE(testing_support::ResizeWindow(kTitle, 40, 30));
  for (int i = 0; i < 5; ++i) window.Show(frame);
}

TEST_F(WindowTest, ClosingItDeliversQuit) {
  Window window(Patient(), Settings());
  const DisplayFrame frame = Frame();
  window.Show(frame);
  ASSERT_TRUE(testing_support::AskToClose(kTitle));
  ASSERT_TRUE(ShowUntil(window, frame, [&] { return window.closed(); }));
  EXPECT_THAT(window.TakeCommands(), Contains(Command::kQuit));
  window.Show(frame);
  EXPECT_TRUE(window.TakeCommands().empty());
}

TEST_F(WindowTest, WhatIsNotFiniteOrWholeIsNotDrawn) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  frame.needle->tip_in_ct_mm[1] = nan;
  frame.ct_from_probe->translation()[0] = std::numeric_limits<double>::infinity();
  frame.target_in_ct_mm->setConstant(nan);
  frame.video->camera.camera_from_ct.translation()[2] = nan;
  frame.fluoroscopy.pixels.resize(7);
  frame.session_s = nan;
  frame.force = {.needle_n = nan, .probe_n = nan, .limit_n = nan};
  frame.latency.pictures_per_s = nan;
  const Shot shot = ShotOf(window, frame);
  EXPECT_EQ(window.layout().Find(ViewKind::kFluoroscopy), nullptr);
  EXPECT_EQ(shot.Count(window.layout().Find(ViewKind::kVideo)->place, IsYellow), 0);
  frame.ultrasound.probe.reset();
  window.Show(frame);
  EXPECT_EQ(window.layout().Find(ViewKind::kUltrasound), nullptr);
}

TEST_F(WindowTest, RefusesSettingsThatItCannotMeet) {
  WindowSettings settings = Settings();
  settings.width_px = 10;
  EXPECT_THAT(([&] { Window(Patient(), settings); }),
              ThrowsMessage<InputError>(HasSubstr("allowed is 320 x 240")));
  settings = Settings();
  settings.overlay_scale = 0.0;
  EXPECT_THROW(Window(Patient(), settings), InputError);
  settings = Settings();
  settings.max_triangles = 10;
  EXPECT_THROW(Window(Patient(), settings), InputError);
  settings = Settings();
  settings.edge_falloff_share = std::nan("");
  EXPECT_THROW(Window(Patient(), settings), InputError);
}

TEST(NoDisplay, IsSaidWithWhatToDo) {
  const char* before = std::getenv("DISPLAY");
  const std::string kept = before == nullptr ? "" : before;
  unsetenv("DISPLAY");
  EXPECT_THAT([] { CheckDisplay(); }, ThrowsMessage<InputError>(testing::AllOf(
                                          HasSubstr("DISPLAY is not set"), HasSubstr("xvfb-run"),
                                          HasSubstr("--headless"))));
  EXPECT_THROW(Window({}, {}), InputError);
  setenv("DISPLAY", ":63999", 1);
  EXPECT_THAT([] { CheckDisplay(); }, ThrowsMessage<InputError>(HasSubstr("the X server :63999")));
  if (before != nullptr) setenv("DISPLAY", kept.c_str(), 1);
}

}  // namespace
}  // namespace acus::display
