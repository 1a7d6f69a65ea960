#include "acus/rig/tracking/pose_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "acus/base/core/error.h"
#include "support/allocation_counter.h"

namespace acus::tracking {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

TrackedPose Reading(std::int64_t time_ns, double x_mm) {
  const Eigen::Isometry3d pose = Eigen::Translation3d(x_mm, 2 * x_mm, 3 * x_mm) *
                                 AngleAxisd(1e-3 * x_mm, Vector3d(1, 2, 3).normalized());
  return {.time_ns = time_ns,
          .source_time_ns = 7 * time_ns,
          .measured_ns = time_ns - 1,
          .reference_from_tool = pose,
          .valid = true,
          .number = 0};
}

TEST(PoseBoard, IsEmptyBeforeTheFirstReading) {
  const PoseBoard board({"Needle", "Probe"});
  EXPECT_EQ(board.Find("Probe"), 1u);
  EXPECT_FALSE(board.Find("probe").has_value());
  const TrackedPose none = board.Latest(1);
  EXPECT_FALSE(none.valid);
  EXPECT_EQ(none.number, 0u);
  EXPECT_EQ(none.AgeNs(1), INT64_MAX);
}

TEST(PoseBoard, RefusesNamesThatCannotBeDistinguished) {
  EXPECT_THROW(PoseBoard({"Needle", "Needle"}), InputError);
  EXPECT_THROW(PoseBoard({""}), InputError);
}

TEST(PoseBoard, GivesBackTheBitsOfTheLatestReading) {
  PoseBoard board({"Needle", "Probe"});
  board.Publish(0, Reading(10, 1.0));
  board.Publish(0, Reading(20, 1.0 / 3.0));
  const TrackedPose latest = board.Latest(0);
  EXPECT_EQ(latest.time_ns, 20);
  EXPECT_EQ(latest.source_time_ns, 140);
  EXPECT_EQ(latest.measured_ns, 19);
  EXPECT_EQ(latest.number, 2u);
  EXPECT_TRUE(latest.valid);
  EXPECT_TRUE(latest.reference_from_tool == Reading(20, 1.0 / 3.0).reference_from_tool);
  EXPECT_EQ(latest.AgeNs(25), 5);
  EXPECT_EQ(board.Latest(1).number, 0u);
}

TEST(PoseBoard, KeepsTheLastGoodPoseOfAToolThatIsNotSeen) {
  PoseBoard board({"Needle"});
  board.Publish(0, Reading(10, 5.0));
  TrackedPose lost = Reading(20, 99.0);
  lost.valid = false;
  board.Publish(0, lost);
  const TrackedPose latest = board.Latest(0);
  EXPECT_FALSE(latest.valid);
  EXPECT_EQ(latest.time_ns, 20);
  EXPECT_TRUE(latest.reference_from_tool == Reading(10, 5.0).reference_from_tool);
}

TEST(PoseBoard, ReadersNeverSeeHalfAReading) {
  constexpr int kReadings = 200'000;
  PoseBoard board({"Needle"});
  std::atomic<bool> done{false};
  std::atomic<std::uint64_t> torn{0}, seen{0}, backwards{0};
  std::thread reader([&] {
    std::uint64_t last = 0;
    while (!done.load()) {
      const TrackedPose pose = board.Latest(0);
      if (pose.number == 0) continue;
      const Vector3d t_mm = pose.reference_from_tool.translation();
      const double x_mm = static_cast<double>(pose.time_ns % 1000);
      if (t_mm != Vector3d(x_mm, 2 * x_mm, 3 * x_mm)) ++torn;
      if (pose.number < last) ++backwards;
      last = pose.number;
      ++seen;
    }
  });
  for (int i = 1; i <= kReadings; ++i) board.Publish(0, Reading(i, i % 1000));
  while (seen == 0) std::this_thread::yield();
  done = true;
  reader.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(board.Latest(0).number, kReadings);
}

TEST(PoseBoard, JournalHoldsEveryReadingInOrderAndCountsWhatDoesNotFit) {
  PoseBoard board({"Needle", "Probe"}, /*journal_capacity=*/8);
  for (int i = 0; i < 11; ++i) board.Publish(i % 2, Reading(i + 1, i));
  EXPECT_EQ(board.lost_from_journal(), 3u);
  EXPECT_EQ(board.Latest(0).time_ns, 11) << "what does not fit is published all the same";
  std::vector<ToolReading> taken(5);
  ASSERT_EQ(board.TakeReadings(taken), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(taken[i].tool, i % 2);
    EXPECT_EQ(taken[i].pose.time_ns, i + 1);
  }
  board.Publish(1, Reading(100, 1));
  ASSERT_EQ(board.TakeReadings(taken), 4u);
  EXPECT_EQ(taken[2].pose.time_ns, 8);
  EXPECT_EQ(taken[3].pose.time_ns, 100);
  EXPECT_EQ(board.TakeReadings(taken), 0u);
}

TEST(PoseBoard, AllocatesNothingOnceMade) {
  PoseBoard board({"Needle"}, 4);
  std::vector<ToolReading> taken(4);
  const auto before = testing_support::num_allocations.load();
  double sum_mm = 0.0;
  for (int i = 1; i <= 100; ++i) {
    board.Publish(0, Reading(i, i));
    sum_mm += board.Latest(0).reference_from_tool.translation().x();
    board.TakeReadings(taken);
  }
  EXPECT_EQ(testing_support::num_allocations.load() - before, 0);
  EXPECT_EQ(sum_mm, 5050.0);
}

}  // namespace
}  // namespace acus::tracking
