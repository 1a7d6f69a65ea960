// A real window under a virtual X server.
#include "acus/window/window.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <optional>

#include "acus/base/core/error.h"
#include "acus/window/loading_screen.h"
#include "acus/window/marks.h"
#include "acus/window/screen.h"
#include "support/stereo_visuals.h"
#include "support/window_events.h"
#include "support/window_input.h"
#include "support/window_scene.h"

namespace acus::window {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST_F(WindowTest, EveryViewShowsItsImage) {
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
  EXPECT_GT(grey_share(ViewKind::kEffect, 180), 0.3);
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

TEST_F(WindowTest, OpensBeforeThePatientIsThereAndShowsHowFarThatIs) {
  LoadingScreen loading(Settings());
  RunContext context = loading.Shown(RunContext());
  context.on_progress("reading the CT", 0.5);
  std::unique_ptr<Screen> screen = loading.Release();
  const auto bright = [](const image::ColourImage& image) {
    return Shot{image}.Count({.left = 300, .top = 300, .width = 680, .height = 150},
                             [](int r, int, int) { return r > 150; });
  };
  const auto bar = [](const image::ColourImage& image) {
    return Shot{image}.Count({.left = 400, .top = 380, .width = 480, .height = 60}, IsCyan);
  };
  const image::ColourImage shown = screen->Screenshot();
  EXPECT_GT(bright(shown), 800) << "texts";
  EXPECT_NEAR(bar(shown), 213 * 6, 80) << "half of the bar";
  context.on_progress("reading the CT", 1.0);  // Nothing is drawn any more.
  Window window(Patient(), Settings(), std::move(screen));
  window.Show(Frame());
  EXPECT_EQ(window.layout().views.size(), 5U);
  EXPECT_EQ(bar(window.Screenshot()), 0);
}

TEST_F(WindowTest, WhatIsNotThereLeavesItsPlaceToTheOthers) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  frame.video.reset();
  frame.effects.clear();
  window.Show(frame);
  EXPECT_EQ(window.layout().views.size(), 3U);
  EXPECT_EQ(window.layout().Find(ViewKind::kVideo), nullptr);
  Window empty({}, Settings());
  empty.Show({});
  EXPECT_TRUE(empty.layout().views.empty());
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
  // In the ultrasound image: probe x and depth, at their scale.
  const Layout layout = window.layout();
  const auto image = acoustics::ImageOf(*frame.ultrasound.probe);
  const Rectangle place = Fit(
      ImageRoom(ViewKind::kUltrasound, layout.Find(ViewKind::kUltrasound)->place, SizesFor(800)),
      image.width_px * image.lateral_mm_per_px, image.height_px * image.axial_mm_per_px);
  const double px_per_mm = place.width / (image.width_px * image.lateral_mm_per_px);
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
                                     {"r", Command::kAutoGain},
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

TEST_F(WindowTest, FaultsAreRedInTheBarAndFrozenImagesAreMarked) {
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
  const acoustics::Probe& probe = *frame.ultrasound.probe;
  const image::ImageGeometry geometry = acoustics::ImageOf(probe);
  Rectangle inside = Fit(ImageRoom(ViewKind::kUltrasound, ultrasound, SizesFor(800)),
                         geometry.width_px * geometry.lateral_mm_per_px,
                         geometry.height_px * geometry.axial_mm_per_px);
  inside = {inside.left + 3, inside.top + 3, inside.width - 6, inside.height - 6};
  const int before = ShotOf(window, frame).Count(ultrasound, is_amber);
  const int inside_before = ShotOf(window, frame).Count(inside, is_amber);
  frame.ultrasound.frozen = true;
  EXPECT_GT(ShotOf(window, frame).Count(ultrasound, is_amber), before + 800);
  EXPECT_EQ(ShotOf(window, frame).Count(inside, is_amber), inside_before)
      << "nothing is printed over the image";
}

TEST_F(WindowTest, ToolsThrowShadowsOnTheSkin) {
  PatientOnDisplay patient = Patient();
  patient.in_teaching_view.pop_back();  // Skin only, and hardly transparent.
  patient.in_teaching_view[0].opacity = 0.9;
  patient.in_teaching_view[0].colour = {0.9F, 0.9F, 0.9F};
  Window window(patient, Settings());
  DisplayFrame frame;
  // Over the front of the ball, far enough off that it does not hide its shadow. Seen from there,
  // as the eye begins on the needle's side.
  frame.needle = Frame().needle;
  frame.needle->axis_in_ct = Eigen::Vector3d::UnitZ();
  frame.needle->tip_in_ct_mm = {30.0, -140.0, 60.0};
  const Rectangle on_ball{.left = 510, .top = 320, .width = 100, .height = 120};
  const auto is_shade = [](int r, int g, int b) {
    return r < 90 && std::abs(r - g) < 15 && std::abs(g - b) < 15 && r > 30;
  };
  const int with = ShotOf(window, frame).Count(on_ball, is_shade);
  frame.needle->tip_in_ct_mm[1] = 140.0;  // Behind him: no shadow, and the needle hidden.
  const int without = ShotOf(window, frame).Count(on_ball, is_shade);
  EXPECT_EQ(without, 0);
  EXPECT_GT(with, 80);
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

class ShutterStereo : public WindowTest {
 protected:
  /// Presses the key of stereo so often, each time until the window has taken it.
  static void Press(Window& window, const DisplayFrame& frame, int times) {
    if (!input_) input_.emplace();  // It waits for the pointer to move: once is enough.
    for (int i = 0; i < times; ++i) {
      input_->Key("s");
      ASSERT_TRUE(ShowUntil(window, frame, [&] { return !window.TakeCommands().empty(); }));
    }
  }

 private:
  static inline std::optional<testing_support::WindowInput> input_;
};

TEST_F(ShutterStereo, IsSideBySideWhereTheDriverHasNone) {
  if (Screen("stereo?", 100, 100).has_shutter()) GTEST_SKIP() << "this driver has it";
  Window window(Patient(), Settings());
  DisplayFrame frame;
  frame.needle = Frame().needle;
  Press(window, frame, 1);
  const Shot side_by_side = ShotOf(window, frame);
  Press(window, frame, 2);
  const Shot shutter = ShotOf(window, frame);
  int differ_in_title = 0;
  int differ_below = 0;
  for (int row = 0; row < shutter.image.height; ++row) {
    for (int column = 0; column < shutter.image.width; ++column) {
      const bool differs = (shutter.At(column, row) - side_by_side.At(column, row)).any();
      if (differs) (row < 40 ? differ_in_title : differ_below) += 1;
    }
  }
  EXPECT_GT(differ_in_title, 200) << "the title says that there is none";
  EXPECT_EQ(differ_below, 0);
  Press(window, frame, 1);
  const Shot off = ShotOf(window, frame);
  EXPECT_FALSE((off.At(640, 300) - shutter.At(640, 300)).isZero() &&
               (off.At(400, 300) - shutter.At(400, 300)).isZero());
}

TEST_F(ShutterStereo, DrawsBothEyes) {
  const testing_support::OfferShutterStereo driver;
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  Press(window, frame, 3);
  ShotOf(window, frame);
  EXPECT_EQ(window.layout().views.size(), 1U) << "the view in 3D alone";
  const Shot left{window.Screenshot(EyeSide::kLeft)};
  const Shot right{window.Screenshot(EyeSide::kRight)};
  int differ = 0;
  int alike = 0;
  int lit = 0;
  for (int row = 100; row < 700; ++row) {
    for (int column = 40; column < 1240; ++column) {
      const int by = (left.At(column, row) - right.At(column, row)).abs().maxCoeff();
      (by > 12 ? differ : alike) += 1;
      if (right.At(column, row).maxCoeff() > 100) ++lit;
    }
  }
  EXPECT_GT(differ, 500) << "what is nearer is elsewhere";
  EXPECT_GT(alike, 5 * differ) << "else it is the same scene";
  EXPECT_GT(lit, 1000);
  // Off again: both eyes see the same.
  Press(window, frame, 1);
  ShotOf(window, frame);
  EXPECT_EQ(window.Screenshot(EyeSide::kLeft).rgb, window.Screenshot(EyeSide::kRight).rgb);
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
  const Rectangle place = window.layout().Find(ViewKind::kEffect)->place;
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

TEST_F(WindowTest, AnEffectsImageHasAPlaceAndATitle) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  image::ColourImage image;
  image.Resize(100, 100);
  std::ranges::fill(image.rgb, std::uint8_t{90});
  frame.effects.push_back({"sway", "Sway of the table", {{}, image}});
  const Shot shot = ShotOf(window, frame);
  ASSERT_EQ(window.layout().views.size(), 6U);
  const Layout layout = window.layout();
  Rectangle place = layout.Find(ViewKind::kSecondEffect)->place;
  EXPECT_GT(shot.Count(place, [](int r, int, int) { return std::abs(r - 90) <= 2; }),
            place.width * place.height / 4);
  place.height = 24;
  EXPECT_GT(shot.Count(place, [](int r, int, int) { return r > 190; }), 30);
  frame.effects[1].pixels.colour.rgb.resize(7);
  window.Show(frame);
  EXPECT_EQ(window.layout().Find(ViewKind::kSecondEffect), nullptr);
}

TEST_F(WindowTest, WhatIsNotFiniteOrWholeIsNotDrawn) {
  Window window(Patient(), Settings());
  DisplayFrame frame = Frame();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  frame.needle->tip_in_ct_mm[1] = nan;
  frame.ct_from_probe->translation()[0] = std::numeric_limits<double>::infinity();
  frame.target_in_ct_mm->setConstant(nan);
  frame.video->camera.camera_from_ct.translation()[2] = nan;
  frame.effects[0].pixels.gray.pixels.resize(7);
  frame.session_s = nan;
  frame.force = {.needle_n = nan, .probe_n = nan, .limit_n = nan};
  frame.latency.images_per_s = nan;
  const Shot shot = ShotOf(window, frame);
  EXPECT_EQ(window.layout().Find(ViewKind::kEffect), nullptr);
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
}  // namespace acus::window
