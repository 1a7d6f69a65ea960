#include "acus/window/steering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace acus::window {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Kind = InputEvent::Kind;

const std::vector<ViewKind> kShown(kViewKinds.begin(), kViewKinds.end());

class SteeringTest : public ::testing::Test {
 protected:
  void Send(InputEvent event) { steering_.Handle(std::span(&event, 1), layout_, kShown); }
  void Key(const std::string& key, bool shift = false) {
    Send({.kind = Kind::kKeyDown, .key = key, .button = 0, .column = 0, .row = 0, .shift = shift});
    Send({.kind = Kind::kKeyUp, .key = key, .button = 0, .column = 0, .row = 0, .shift = shift});
  }
  void Mouse(Kind kind, int button, int column, int row) {
    Send({.kind = kind, .key = "", .button = button, .column = column, .row = row, .shift = false});
  }
  Eigen::Vector2i Middle(ViewKind view) const {
    const Rectangle& place = layout_.Find(view)->place;
    return {place.left + place.width / 2, place.top + place.height / 2};
  }
  void Drag(ViewKind view, int button, int right, int down) {
    const Eigen::Vector2i at = Middle(view);
    Mouse(Kind::kMove, 0, at[0], at[1]);
    Mouse(Kind::kButtonDown, button, at[0], at[1]);
    Mouse(Kind::kMove, 0, at[0] + right, at[1] + down);
    Mouse(Kind::kButtonUp, button, at[0] + right, at[1] + down);
    Mouse(Kind::kMove, 0, at[0], at[1]);
  }

  Layout layout_ = LayOut(1280, 800, kShown, {});
  Steering steering_;
};

TEST_F(SteeringTest, KeysGiveTheirCommands) {
  for (const auto& [key, shift, command] : {std::tuple{"f", false, Command::kFreeze},
                                            {"g", false, Command::kGainUp},
                                            {"G", true, Command::kGainDown},
                                            {"r", false, Command::kAutoGain},
                                            {"d", false, Command::kDeeper},
                                            {"D", true, Command::kShallower},
                                            {"t", false, Command::kMarkTarget},
                                            {"b", false, Command::kHoldBreath},
                                            {"w", false, Command::kSwapHands},
                                            {"v", false, Command::kNextView},
                                            {"a", false, Command::kGrid},
                                            {"o", false, Command::kOverlayMore},
                                            {"O", true, Command::kOverlayLess},
                                            {"n", false, Command::kNeedleGuide},
                                            {"u", false, Command::kUndo},
                                            {"e", false, Command::kFigures},
                                            {"s", false, Command::kStereo},
                                            {"h", false, Command::kHelp},
                                            {"m", false, Command::kVolume},
                                            {"l", false, Command::kVolumeLook},
                                            {"p", false, Command::kVolumeDenser},
                                            {"P", true, Command::kVolumeFainter},
                                            {"c", false, Command::kVolumeCut},
                                            {"x", false, Command::kCutOn},
                                            {"X", true, Command::kCutBack},
                                            {"3", false, Command::kCameraPreset},
                                            {"Tab", false, Command::kSteerOther}}) {
    Key(key, shift);
    EXPECT_THAT(steering_.TakeCommands(), ElementsAre(command)) << key;
  }
  Key("z");
  Key("F5");
  EXPECT_THAT(steering_.TakeCommands(), IsEmpty());
}

TEST_F(SteeringTest, QuitNeedsTwoPressesAndAnotherKeyCancelsIt) {
  Key("q");
  EXPECT_TRUE(steering_.choice().quit_asked);
  Key("f");
  EXPECT_FALSE(steering_.choice().quit_asked);
  EXPECT_THAT(steering_.TakeCommands(), ElementsAre(Command::kFreeze));
  Key("q");
  Key("q");
  EXPECT_THAT(steering_.TakeCommands(), ElementsAre(Command::kQuit));
  EXPECT_FALSE(steering_.closed()) << "the caller ends the session";
}

TEST_F(SteeringTest, AHeldKeyCountsOnceUnlessItMeansMore) {
  const auto hold = [&](const char* key) {
    for (int i = 0; i < 4; ++i) {
      Send(
          {.kind = Kind::kKeyDown, .key = key, .button = 0, .column = 0, .row = 0, .shift = false});
    }
  };
  hold("f");
  EXPECT_EQ(steering_.TakeCommands().size(), 1U);
  hold("g");
  EXPECT_EQ(steering_.TakeCommands().size(), 4U);
}

TEST_F(SteeringTest, NextViewGoesThroughAllAndBackToTheGrid) {
  for (const ViewKind view : kShown) {
    Key("v");
    ASSERT_TRUE(steering_.choice().alone.has_value());
    EXPECT_EQ(*steering_.choice().alone, view);
  }
  Key("v");
  EXPECT_FALSE(steering_.choice().alone);
  Key("v");
  Key("Escape");
  EXPECT_FALSE(steering_.choice().alone);
}

TEST_F(SteeringTest, OverlayStaysWithinItsRange) {
  for (int i = 0; i < 20; ++i) Key("o");
  EXPECT_DOUBLE_EQ(steering_.choice().overlay_share, 1.0);
  for (int i = 0; i < 40; ++i) Key("O", true);
  EXPECT_DOUBLE_EQ(steering_.choice().overlay_share, 0.0);
}

TEST_F(SteeringTest, TheVolumeViewHasItsRangesAndItsTurns) {
  EXPECT_FALSE(steering_.choice().volume.shown);
  Key("m");
  EXPECT_TRUE(steering_.choice().volume.shown);
  for (int i = 0; i < 30; ++i) Key("P", true);
  EXPECT_NEAR(steering_.choice().volume.opacity, 0.1, 1e-9);
  for (int i = 0; i < 30; ++i) Key("p");
  EXPECT_DOUBLE_EQ(steering_.choice().volume.opacity, 1.0);
  Key("c");
  EXPECT_EQ(steering_.choice().volume.cut, VolumeCut::kAxial);
  Key("x");
  Key("x");
  Key("X", true);
  EXPECT_DOUBLE_EQ(steering_.choice().volume.cut_mm, 5.0);
  for (int i = 1; i < kNumVolumeCuts; ++i) Key("c");
  EXPECT_EQ(steering_.choice().volume.cut, VolumeCut::kNone);
  EXPECT_EQ(steering_.choice().volume.cut_mm, 0.0);
  Drag(ViewKind::kVolume, 1, 12, 5);
  EXPECT_EQ(steering_.TakeEyeMotion().turn_right_px, 12.0);
  EXPECT_TRUE(Steering(true).choice().volume.shown);
}

TEST_F(SteeringTest, DraggingInThe3dViewMovesTheEyeAndElsewhereTheTool) {
  Drag(ViewKind::kTeaching, 1, 30, -10);
  EyeMotion eye = steering_.TakeEyeMotion();
  EXPECT_EQ(eye.turn_right_px, 30.0);
  EXPECT_EQ(eye.turn_down_px, -10.0);
  EXPECT_EQ(steering_.TakeHandInput().moved_mm.norm(), 0.0);
  Drag(ViewKind::kUltrasound, 1, 40, 20);
  const HandInput hand = steering_.TakeHandInput();
  EXPECT_GT(hand.moved_mm[0], 0.0) << "right";
  EXPECT_LT(hand.moved_mm[1], 0.0) << "down";
  EXPECT_EQ(hand.moved_mm[2], 0.0);
  EXPECT_EQ(steering_.TakeEyeMotion().turn_right_px, 0.0);
  Drag(ViewKind::kVideo, 3, 40, 0);
  EXPECT_GT(steering_.TakeHandInput().turned_rad[1], 0.0);
  EXPECT_EQ(steering_.TakeHandInput().turned_rad.norm(), 0.0) << "told once";
}

TEST_F(SteeringTest, WheelAdvancesTheNeedleAndZoomsIn3d) {
  Eigen::Vector2i at = Middle(ViewKind::kUltrasound);
  Mouse(Kind::kWheelForward, 0, at[0], at[1]);
  Mouse(Kind::kWheelForward, 0, at[0], at[1]);
  EXPECT_EQ(steering_.TakeHandInput().advanced_mm, 2.0);
  at = Middle(ViewKind::kTeaching);
  Mouse(Kind::kWheelForward, 0, at[0], at[1]);
  EXPECT_LT(steering_.TakeEyeMotion().zoom, 1.0);
  Mouse(Kind::kWheelForward, 0, 600, 790);
  EXPECT_EQ(steering_.TakeHandInput().advanced_mm, 0.0) << "over the status bar";
}

TEST_F(SteeringTest, HeldKeysAreReportedUntilReleased) {
  const auto key = [&](Kind kind, const char* name, bool shift) {
    Send({.kind = kind, .key = name, .button = 0, .column = 0, .row = 0, .shift = shift});
  };
  key(Kind::kKeyDown, "Up", false);
  key(Kind::kKeyDown, "Next", false);
  key(Kind::kKeyDown, "space", true);
  for (int i = 0; i < 2; ++i) {
    const HandInput hand = steering_.TakeHandInput();
    EXPECT_EQ(hand.held, Eigen::Vector2d(0.0, 1.0));
    EXPECT_EQ(hand.held_advance, 1.0);
    EXPECT_TRUE(hand.pedal);
    EXPECT_TRUE(hand.fine);
  }
  key(Kind::kKeyUp, "space", false);
  key(Kind::kKeyUp, "Up", false);
  EXPECT_FALSE(steering_.TakeHandInput().pedal);
  EXPECT_EQ(steering_.TakeHandInput().held[1], 0.0);
}

TEST_F(SteeringTest, AKeyMovesTheToolHoweverBrieflyItIsPressed) {
  Key("Left");
  Key("Up");
  Key("Next");
  HandInput hand = steering_.TakeHandInput();
  EXPECT_EQ(hand.held, Eigen::Vector2d::Zero()) << "released already";
  EXPECT_EQ(hand.moved_mm, Eigen::Vector3d(-0.5, 0.5, 0.0));
  EXPECT_EQ(hand.advanced_mm, 0.5);
  Key("Prior", true);
  hand = steering_.TakeHandInput();
  EXPECT_DOUBLE_EQ(hand.advanced_mm, -0.05) << "a tenth with Shift";
  // The X server repeats a held key.
  for (int i = 0; i < 5; ++i) {
    Send({.kind = Kind::kKeyDown,
          .key = "Right",
          .button = 0,
          .column = 0,
          .row = 0,
          .shift = false});
  }
  EXPECT_EQ(steering_.TakeHandInput().moved_mm.x(), 0.5);
}

TEST_F(SteeringTest, ClosingTheWindowIsToQuit) {
  Mouse(Kind::kClose, 0, 0, 0);
  EXPECT_TRUE(steering_.closed());
  EXPECT_THAT(steering_.TakeCommands(), ElementsAre(Command::kQuit));
}

}  // namespace
}  // namespace acus::window
