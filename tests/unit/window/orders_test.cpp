#include "acus/window/orders.h"

#include <gtest/gtest.h>

#include "acus/run/live/image_bounds.h"
#include "acus/window/hand_steering.h"

namespace acus::window {
namespace {

using live::kLargestDepthMm;
using live::kLargestGainDb;
using live::kLeastDepthMm;
using session::CommandKind;

TEST(Orders, AKeySwitchesOnAndOff) {
  live::LiveSnapshot snapshot;
  EXPECT_EQ(OrderOf(Command::kFreeze, snapshot, {})->kind, CommandKind::kFreezeImage);
  EXPECT_EQ(OrderOf(Command::kHoldBreath, snapshot, {})->kind, CommandKind::kHoldBreath);
  snapshot.frozen = snapshot.breath_held = true;
  EXPECT_EQ(OrderOf(Command::kFreeze, snapshot, {})->kind, CommandKind::kRunImage);
  EXPECT_EQ(OrderOf(Command::kHoldBreath, snapshot, {})->kind, CommandKind::kBreatheOn);
  EXPECT_EQ(OrderOf(Command::kSwapHands, snapshot, {})->kind, CommandKind::kSwapHands);
  EXPECT_EQ(OrderOf(Command::kMarkTarget, snapshot, {})->kind, CommandKind::kMarkTarget);
}

TEST(Orders, GainAndDepthGoInStepsWithinBounds) {
  const live::LiveSnapshot snapshot;
  const ImageSetting present{.gain_db = 10.0, .depth_mm = 95.0};
  EXPECT_EQ(OrderOf(Command::kGainUp, snapshot, present)->value, 13.0);
  EXPECT_EQ(OrderOf(Command::kGainDown, snapshot, present)->value, 7.0);
  EXPECT_EQ(OrderOf(Command::kDeeper, snapshot, present)->value, 105.0);
  EXPECT_EQ(OrderOf(Command::kShallower, snapshot, present)->value, 85.0);
  EXPECT_EQ(OrderOf(Command::kAutoGain, snapshot, {.auto_gain_db = 17.0})->value, 17.0);
  EXPECT_EQ(OrderOf(Command::kAutoGain, snapshot, {.auto_gain_db = 70.0})->value, kLargestGainDb);
  const ImageSetting least{.gain_db = -59.0, .depth_mm = 25.0};
  EXPECT_EQ(OrderOf(Command::kGainDown, snapshot, least)->value, -kLargestGainDb);
  EXPECT_EQ(OrderOf(Command::kShallower, snapshot, least)->value, kLeastDepthMm);
  const ImageSetting most{.gain_db = 59.0, .depth_mm = 299.0};
  EXPECT_EQ(OrderOf(Command::kGainUp, snapshot, most)->value, kLargestGainDb);
  EXPECT_EQ(OrderOf(Command::kDeeper, snapshot, most)->value, kLargestDepthMm);
}

TEST(Orders, KeysPressedFasterThanImagesComeAllCount) {
  const live::LiveSnapshot shown;
  const ImageSetting image{.gain_db = 10.0, .depth_mm = 100.0};
  OrderedSettings ordered;
  double gain_db = 0.0;
  for (int i = 0; i < 3; ++i) {  // Within 90 ms, and the image still shows the first gain.
    const double now_s = 1.0 + 0.03 * i;
    ordered.Refresh(shown, image, now_s);
    const auto order = *OrderOf(Command::kGainUp, ordered.snapshot(), ordered.image());
    ordered.Add(order, now_s);
    gain_db = order.value;
  }
  EXPECT_EQ(gain_db, 19.0);
  // A key that switches: on and off again.
  const auto on = *OrderOf(Command::kFreeze, ordered.snapshot(), ordered.image());
  ordered.Add(on, 1.1);
  EXPECT_EQ(on.kind, CommandKind::kFreezeImage);
  EXPECT_EQ(OrderOf(Command::kFreeze, ordered.snapshot(), ordered.image())->kind,
            CommandKind::kRunImage);
  ordered.Refresh(shown, image, 2.0);
  EXPECT_EQ(ordered.image().gain_db, 10.0) << "the image has the last word";
}

TEST(Orders, AKeyWithoutEffectSaysWhy) {
  const SessionAbilities all{.breath_can_be_held = true, .has_both_tools = true, .has_probe = true};
  for (const Command command : {Command::kHoldBreath, Command::kSwapHands, Command::kMarkTarget,
                                Command::kGainUp, Command::kFreeze}) {
    EXPECT_EQ(WhyWithoutEffect(command, all), "");
  }
  EXPECT_EQ(WhyWithoutEffect(Command::kHoldBreath, {}),
            "This patient does not breathe: B has no effect.");
  EXPECT_NE(WhyWithoutEffect(Command::kSwapHands, {}), "");
  EXPECT_NE(WhyWithoutEffect(Command::kMarkTarget, {.has_exercise_target = true}), "");
}

TEST(Orders, WhatTheWindowDoesItselfIsNoOrder) {
  for (const Command command : {Command::kQuit, Command::kGrid, Command::kHelp, Command::kStereo,
                                Command::kSteerOther, Command::kNextView}) {
    EXPECT_FALSE(OrderOf(command, {}, {}).has_value());
  }
}

TEST(Steering, MovesAlongTheNeedleAndAsTheMouseGoes) {
  Eigen::Isometry3d device_from_tool = Eigen::Isometry3d::Identity();
  device_from_tool.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
  HandInput input;
  input.moved_mm = {1.0, 2.0, 0.0};
  input.advanced_mm = 4.0;
  const ToolWay way = WayOf(input, device_from_tool, 0.1);
  const Eigen::Vector3d expected(1.0, 2.0 - 4.0 * std::sin(0.5), 4.0 * std::cos(0.5));
  EXPECT_LT((way.way_mm - expected).norm(), 1e-12);
  // Keys that are held: 30 mm/s, a tenth of it with Shift.
  HandInput held;
  held.held = {-1.0, 0.0};
  held.held_advance = 1.0;
  EXPECT_LT(
      (WayOf(held, Eigen::Isometry3d::Identity(), 0.1).way_mm - Eigen::Vector3d(-3.0, 0.0, 3.0))
          .norm(),
      1e-12);
  held.fine = true;
  EXPECT_NEAR(WayOf(held, Eigen::Isometry3d::Identity(), 0.1).way_mm.x(), -0.3, 1e-12);
  EXPECT_TRUE(WayOf({}, device_from_tool, 0.1).IsZero());
  EXPECT_NEAR(WayOf(held, Eigen::Isometry3d::Identity(), 0.1, 0.5).way_mm.x(), -0.15, 1e-12);
}

TEST(SpeedShare, FallsTowardsTheTarget) {
  EXPECT_EQ(SpeedShare(std::nullopt), 1.0);
  EXPECT_EQ(SpeedShare(100.0), 1.0);
  EXPECT_DOUBLE_EQ(SpeedShare(20.0), 0.5);
  // A tap of a tenth of a second is less than the 3 mm that a target of a puncture leaves.
  EXPECT_LT(0.1 * kHeldMmPerS * SpeedShare(0.5), 1.0);
  EXPECT_GT(SpeedShare(0.0), 0.0);
}

TEST(Steering, TheGoalStaysWhereTheNeedleIsHeld) {
  haptics::HandSteering hand;
  hand.SetGoal(Eigen::Isometry3d::Identity());
  haptics::VirtualHand follower({}, &hand);
  HandInput input;
  input.moved_mm = {2.0, 0.0, 0.0};
  input.advanced_mm = 3.0;
  Steer(&hand, Eigen::Isometry3d::Identity(), input, 0.01, /*may_advance=*/false);
  follower.Step({}, 0.001);
  EXPECT_EQ(hand.goal().translation(), Eigen::Vector3d(2.0, 0.0, 0.0));
  input.advanced_mm = -3.0;  // Withdrawn it may be.
  Steer(&hand, Eigen::Isometry3d::Identity(), input, 0.01, /*may_advance=*/false);
  follower.Step({}, 0.001);
  EXPECT_EQ(hand.goal().translation(), Eigen::Vector3d(4.0, 0.0, -3.0));
}

TEST(Steering, TheGoalOfAVirtualHandFollows) {
  haptics::HandSteering hand;
  hand.SetGoal(Eigen::Isometry3d::Identity());
  haptics::VirtualHand follower({}, &hand);
  follower.Step({}, 0.001);
  HandInput input;
  input.advanced_mm = 10.0;
  Steer(&hand, Eigen::Isometry3d::Identity(), input, 0.01);
  for (int i = 0; i < 1000; ++i) follower.Step({}, 0.001);
  EXPECT_NEAR(hand.goal().translation().z(), 10.0, 0.5);
  Steer(nullptr, Eigen::Isometry3d::Identity(), input, 0.01);  // A real hand: nothing happens.
}

}  // namespace
}  // namespace acus::window
