#include "acus/rig/tracking/igtl_tools.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::tracking {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix4d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr std::int64_t kIgtlToolsMs = 1'000'000;

Isometry3d Some(double x_mm) {
  return Translation3d(x_mm, 20.0, 30.0) * AngleAxisd(0.3, Vector3d(1, 2, 3).normalized());
}
MessageTimes At(std::int64_t ms) {
  return {.source_ns = 0, .arrival_ns = ms * kIgtlToolsMs};
}
std::vector<IgtlTool> NeedleAndProbe() {
  return {{.tool = "needle", .device = "NeedleToReference"},
          {.tool = "probe", .device = "ProbeToReference"}};
}

TEST(IgtlTools, PublishesByNameAndCountsTheOthers) {
  PoseBoard board({"needle", "probe"});
  IgtlTools tools(NeedleAndProbe(), 200 * kIgtlToolsMs, board);
  tools.Take("ProbeToReference", Some(5.0).matrix(), true, At(1));
  tools.Take("StylusToReference", Some(6.0).matrix(), true, At(2));
  tools.Take("StylusToReference", Some(6.0).matrix(), true, At(3));
  EXPECT_EQ(board.Latest(0).number, 0u);
  const TrackedPose probe = board.Latest(1);
  EXPECT_TRUE(probe.valid);
  EXPECT_EQ(probe.time_ns, 1 * kIgtlToolsMs);
  EXPECT_EQ(probe.measured_ns, probe.time_ns) << "without stamps, the arrival";
  EXPECT_LT((probe.reference_from_tool.matrix() - Some(5.0).matrix()).norm(), 1e-12);
  EXPECT_EQ(tools.counts().readings, 1u);
  EXPECT_EQ(tools.counts().other_tools, 2u);
  EXPECT_THAT(tools.other_names(), testing::ElementsAre("StylusToReference"));
}

TEST(IgtlTools, LongNamesAreKnownByWhatFitsIntoAMessage) {
  PoseBoard board({"tip"});
  IgtlTools tools({{.tool = "tip", .device = "NeedleTipToReferenceTransform"}}, kIgtlToolsMs,
                  board);
  tools.Take("NeedleTipToReference", Some(5.0).matrix(), true, At(1));
  EXPECT_EQ(board.Latest(0).number, 1u);
}

TEST(IgtlTools, ComposesWithTheReferenceAndTheCalibration) {
  PoseBoard board({"needle"});
  const Isometry3d tracker_from_reference = Some(100.0), tracker_from_needle = Some(-40.0);
  const Isometry3d needle_from_tip = Isometry3d(Translation3d(0.0, 0.0, 150.0));
  IgtlTools tools({{.tool = "needle",
                    .device = "NeedleToTracker",
                    .relative_to = "ReferenceToTracker",
                    .marker_from_tool = needle_from_tip}},
                  200 * kIgtlToolsMs, board);
  tools.Take("NeedleToTracker", tracker_from_needle.matrix(), true, At(1));
  EXPECT_FALSE(board.Latest(0).valid) << "no reference yet";
  tools.Take("ReferenceToTracker", tracker_from_reference.matrix(), true, At(2));
  tools.Take("NeedleToTracker", tracker_from_needle.matrix(), true, At(3));
  const Isometry3d expected =
      tracker_from_reference.inverse() * tracker_from_needle * needle_from_tip;
  ASSERT_TRUE(board.Latest(0).valid);
  EXPECT_LT((board.Latest(0).reference_from_tool.matrix() - expected.matrix()).norm(), 1e-12);
  // The reference is covered: where the needle is in it cannot be known.
  tools.Take("ReferenceToTracker", Matrix4d::Identity(), false, At(4));
  tools.Take("NeedleToTracker", tracker_from_needle.matrix(), true, At(5));
  EXPECT_FALSE(board.Latest(0).valid);
  // It comes back, then falls silent.
  tools.Take("ReferenceToTracker", tracker_from_reference.matrix(), true, At(6));
  tools.Take("NeedleToTracker", tracker_from_needle.matrix(), true, At(7));
  EXPECT_TRUE(board.Latest(0).valid);
  tools.Take("NeedleToTracker", tracker_from_needle.matrix(), true, At(500));
  EXPECT_FALSE(board.Latest(0).valid);
}

TEST(IgtlTools, AToolThatTheListLeavesOutIsNotSeen) {
  PoseBoard board({"needle", "probe"});
  IgtlTools tools(NeedleAndProbe(), 200 * kIgtlToolsMs, board);
  const ToolMatrix needle{.name = "NeedleToReference", .matrix = Some(1.0).matrix()};
  const ToolMatrix probe{.name = "ProbeToReference", .matrix = Some(2.0).matrix()};
  tools.TakeAll("Tracker", {needle, probe}, At(1));
  EXPECT_TRUE(board.Latest(0).valid);
  EXPECT_TRUE(board.Latest(1).valid);
  // Both in one batch, so at the same time of arrival.
  tools.TakeAll("Tracker", {probe}, At(1));
  EXPECT_FALSE(board.Latest(0).valid);
  EXPECT_TRUE(board.Latest(1).valid);
  EXPECT_EQ(board.Latest(0).number, 2u);
  EXPECT_LT((board.Latest(0).reference_from_tool.matrix() - needle.matrix).norm(), 1e-12)
      << "the last good pose stays";
  // Another tracker's list says nothing about tools of the first.
  tools.TakeAll("Other", {}, At(3));
  EXPECT_TRUE(board.Latest(1).valid);
  tools.TakeAll("Tracker", {needle, probe}, At(4));
  EXPECT_TRUE(board.Latest(0).valid);
  EXPECT_EQ(tools.counts().not_seen, 1u);
}

TEST(IgtlTools, WhatIsNoPoseIsPublishedAsNotValid) {
  PoseBoard board({"needle", "probe"});
  IgtlTools tools(NeedleAndProbe(), 200 * kIgtlToolsMs, board);
  tools.Take("NeedleToReference", Some(1.0).matrix(), true, At(1));
  Matrix4d nan = Some(1.0).matrix(), scaled = nan, mirrored = nan, infinite = nan;
  nan(1, 3) = NAN;
  scaled.topLeftCorner<3, 3>() *= 1.01;
  mirrored.col(0) *= -1.0;
  infinite(0, 3) = INFINITY;
  for (const Matrix4d& bad : {nan, scaled, mirrored, infinite, Matrix4d(Matrix4d::Zero())}) {
    tools.Take("NeedleToReference", bad, true, At(2));
    EXPECT_FALSE(board.Latest(0).valid);
    EXPECT_TRUE(board.Latest(0).reference_from_tool.matrix().allFinite());
    tools.TakeAll("T", {{.name = "NeedleToReference", .matrix = bad}}, At(3));
    EXPECT_FALSE(board.Latest(0).valid);
  }
  EXPECT_EQ(tools.counts().bad_poses, 10u);
  EXPECT_EQ(tools.counts().not_seen, 0u);
}

TEST(IgtlTools, SilenceIsPublishedOnceAndEndsWithTheNextReading) {
  PoseBoard board({"needle", "probe"});
  IgtlTools tools(NeedleAndProbe(), 200 * kIgtlToolsMs, board);
  tools.Take("NeedleToReference", Some(1.0).matrix(), true, At(1));
  tools.PublishSilent(200 * kIgtlToolsMs);
  EXPECT_TRUE(board.Latest(0).valid);
  tools.PublishSilent(201 * kIgtlToolsMs);
  tools.PublishSilent(300 * kIgtlToolsMs);
  EXPECT_FALSE(board.Latest(0).valid);
  EXPECT_EQ(board.Latest(0).number, 2u);
  EXPECT_EQ(board.Latest(1).number, 0u) << "never seen, so not lost";
  EXPECT_EQ(tools.counts().fell_silent, 1u);
  tools.Take("NeedleToReference", Some(1.0).matrix(), true, At(400));
  EXPECT_TRUE(board.Latest(0).valid);
  tools.LinkLost(401 * kIgtlToolsMs);
  EXPECT_FALSE(board.Latest(0).valid);
}

TEST(IgtlTools, StampsThatRepeatOrGoBackAreCounted) {
  PoseBoard board({"needle", "probe"});
  IgtlTools tools(NeedleAndProbe(), 200 * kIgtlToolsMs, board);
  std::int64_t arrival_ms = 0;
  for (const std::int64_t stamp_ms : {1000, 1010, 1010, 1005, 1020}) {
    tools.Take(
        "NeedleToReference", Some(1.0).matrix(), true,
        {.source_ns = stamp_ms * kIgtlToolsMs, .arrival_ns = ++arrival_ms * 10 * kIgtlToolsMs});
  }
  EXPECT_EQ(tools.counts().repeated, 1u);
  EXPECT_EQ(tools.counts().out_of_order, 1u);
  EXPECT_EQ(board.Latest(0).number, 5u);
  EXPECT_EQ(board.Latest(0).source_time_ns, 1020 * kIgtlToolsMs);
  EXPECT_TRUE(tools.clock().known);
}

TEST(IgtlTools, RefusesToolsThatCannotWork) {
  PoseBoard board({"a"});
  EXPECT_THROW(IgtlTools({{.tool = "a", .device = ""}}, kIgtlToolsMs, board), InputError);
  EXPECT_THROW(IgtlTools({{.tool = "a", .device = "X", .relative_to = "X"}}, kIgtlToolsMs, board),
               InputError);
  IgtlTool mirrored{.tool = "a", .device = "X"};
  mirrored.marker_from_tool.matrix()(0, 0) = -1.0;
  EXPECT_THROW(IgtlTools({mirrored}, kIgtlToolsMs, board), InputError);
}

}  // namespace
}  // namespace acus::tracking
