#include "acus/run/live/pose_gate.h"

#include <gtest/gtest.h>
#include <limits>

namespace acus::live {
namespace {

constexpr std::int64_t kPoseGateMs = 1'000'000;

transforms::Pose At(double x_mm) {
  return Eigen::Isometry3d(Eigen::Translation3d(x_mm, 0.0, 0.0));
}

TEST(PoseGate, BelievesAHandAndATrackerThatComesBack) {
  PoseGate gate;
  EXPECT_EQ(gate.Judge(0, At(500.0), true), PoseVerdict::kGood);
  // 0.5 m/s at 1 kHz, then at 30 Hz.
  for (int i = 1; i < 200; ++i) {
    ASSERT_EQ(gate.Judge(i * kPoseGateMs, At(500.0 + 0.5 * i), true), PoseVerdict::kGood);
  }
  EXPECT_EQ(gate.Judge(233 * kPoseGateMs, At(616.0), true), PoseVerdict::kGood);
  EXPECT_EQ(gate.Judge(250 * kPoseGateMs, At(0.0), false), PoseVerdict::kNotSeen);
  EXPECT_EQ(gate.last_good().translation().x(), 616.0);
  EXPECT_EQ(gate.Judge(1250 * kPoseGateMs, At(650.0), true), PoseVerdict::kGood);
}

TEST(PoseGate, AJumpOf50MmIsNotUsedAndTheToolIsBelievedAgainWhenItIsBack) {
  PoseGate gate;
  gate.Judge(0, At(0.0), true);
  EXPECT_EQ(gate.Judge(kPoseGateMs, At(50.0), true), PoseVerdict::kJumped);
  EXPECT_EQ(gate.Judge(33 * kPoseGateMs, At(50.0), true),
            PoseVerdict::kJumped);  // A tracker's interval.
  EXPECT_EQ(gate.last_good().translation().x(), 0.0);
  EXPECT_EQ(gate.Judge(34 * kPoseGateMs, At(0.1), true), PoseVerdict::kGood);
}

TEST(PoseGate, AToolThatStaysWhereItJumpedIsBelievedAfterAWhile) {
  PoseGate gate;
  gate.Judge(0, At(0.0), true);
  int ms = 1;
  while (ms < 1000 &&
         gate.Judge(ms * kPoseGateMs, At(300.0 + 0.01 * ms), true) != PoseVerdict::kGood)
    ++ms;
  EXPECT_EQ(ms, 301);
}

TEST(PoseGate, OneThatJumpsAboutIsNeverBelieved) {
  PoseGate gate;
  gate.Judge(0, At(0.0), true);
  for (int ms = 1; ms < 3000; ++ms) {
    ASSERT_EQ(gate.Judge(ms * kPoseGateMs, At(ms % 2 == 0 ? 300.0 : -300.0), true),
              PoseVerdict::kJumped);
  }
}

TEST(PoseGate, ATurnThatNoHandMakesIsAJump) {
  PoseGate gate;
  gate.Judge(0, At(0.0), true);
  const transforms::Pose turned(
      Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitX())),
      Eigen::Vector3d::Zero());
  EXPECT_EQ(gate.Judge(kPoseGateMs, turned, true), PoseVerdict::kJumped);
}

TEST(PoseGate, WhatIsNotFiniteOrOutOfThisWorldIsNotUsed) {
  PoseGate gate;
  gate.Judge(0, At(1.0), true);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), 1e7, -1e7}) {
    EXPECT_EQ(gate.Judge(kPoseGateMs, At(bad), true), PoseVerdict::kNotFinite) << bad;
  }
  EXPECT_EQ(gate.last_good().translation().x(), 1.0);
}

}  // namespace
}  // namespace acus::live
