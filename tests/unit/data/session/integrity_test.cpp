#include "acus/data/session/integrity.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::session {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// One sample each interval, moving along x at 10 mm/s.
PoseStream Steady(int num_samples, std::int64_t interval_ns) {
  PoseStream stream;
  for (int i = 0; i < num_samples; ++i) {
    const std::int64_t time_ns = i * interval_ns;
    stream.push_back({time_ns,
                      transforms::Pose(Eigen::Quaterniond::Identity(),
                                       Eigen::Vector3d(1e-8 * static_cast<double>(time_ns), 0, 0)),
                      true});
  }
  return stream;
}

void Move(PoseSample& sample, double x_mm) {
  sample.reference_from_tool =
      transforms::Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x_mm, 0, 0));
}

TEST(Integrity, FindsNothingInASteadyRecording) {
  for (const std::int64_t interval_ns : {1'000'000, 33'333'333, 500'000'000}) {
    const auto report = CheckIntegrity(Steady(100, interval_ns));
    EXPECT_TRUE(report.clean()) << interval_ns;
    EXPECT_NEAR(report.median_interval_s, 1e-9 * static_cast<double>(interval_ns), 1e-15);
    EXPECT_NEAR(report.duration_s, 99e-9 * static_cast<double>(interval_ns), 1e-12);
    EXPECT_THAT(Describe(report, "needle"), IsEmpty());
  }
}

TEST(Integrity, FindsAGapThatIsLongerThanTheLimit) {
  PoseStream stream = Steady(100, 1'000'000);
  for (std::size_t i = 60; i < 100; ++i) stream[i].time_ns += 19'000'000;  // 20 ms: just not.
  EXPECT_THAT(CheckIntegrity(stream).gaps, IsEmpty());
  for (std::size_t i = 60; i < 100; ++i) stream[i].time_ns += 1;
  const auto report = CheckIntegrity(stream);
  ASSERT_EQ(report.gaps.size(), 1U);
  EXPECT_EQ(report.gaps[0].sample, 59U);
  EXPECT_EQ(report.gaps[0].time_ns, 59'000'000);
  EXPECT_NEAR(report.gaps[0].amount, 0.020000001, 1e-15);
  EXPECT_FALSE(report.clean());
  EXPECT_THAT(Describe(report, "needle"),
              ElementsAre(HasSubstr("needle: 1 gap without samples, of 0.02 s at 0.059 s")));
}

TEST(Integrity, TakesASlowRateForWhatItIs) {
  PoseStream stream = Steady(50, 100'000'000);
  for (std::size_t i = 20; i < 50; ++i) stream[i].time_ns += 149'000'000;  // 2.49 intervals.
  EXPECT_THAT(CheckIntegrity(stream).gaps, IsEmpty());
  for (std::size_t i = 20; i < 50; ++i) stream[i].time_ns += 2'000'000;
  EXPECT_EQ(CheckIntegrity(stream).gaps.size(), 1U);
}

TEST(Integrity, FindsJumpsByDistanceAndBySpeed) {
  PoseStream far = Steady(10, 100'000'000);
  Move(far[5], 5.0 + 52.0);  // There and back, 520 mm/s.
  EXPECT_EQ(CheckIntegrity(far).jumps.size(), 2U);
  EXPECT_EQ(CheckIntegrity(far).jumps[0].sample, 4U);
  Move(far[5], 5.0 + 48.0);
  EXPECT_THAT(CheckIntegrity(far).jumps, IsEmpty());

  PoseStream fast = Steady(10, 1'000'000);
  Move(fast[5], 6.0);  // 6 m/s.
  EXPECT_EQ(CheckIntegrity(fast).jumps.size(), 2U);
  Move(fast[5], 4.9);  // 4.9 m/s.
  EXPECT_THAT(CheckIntegrity(fast).jumps, IsEmpty());
}

TEST(Integrity, DoesNotTakeJitterForJumps) {
  PoseStream stream = Steady(10, 100'000);  // 10 kHz.
  Move(stream[5], 1.9);                     // 19 m/s, on paper.
  EXPECT_THAT(CheckIntegrity(stream).jumps, IsEmpty());
  Move(stream[5], 2.1);
  EXPECT_EQ(CheckIntegrity(stream).jumps.size(), 2U);
}

TEST(Integrity, CountsInvalidRunsAndLooksForJumpsAcrossThem) {
  PoseStream stream = Steady(20, 1'000'000);
  for (const std::size_t i : {0, 5, 6, 7, 19}) stream[i].valid = false;
  Move(stream[6], 1000.0);  // Not valid: not looked at.
  for (std::size_t i = 8; i < 19; ++i) Move(stream[i], 100.0);
  const auto report = CheckIntegrity(stream);
  EXPECT_EQ(report.num_invalid, 5U);
  ASSERT_EQ(report.invalid_runs.size(), 3U);
  EXPECT_EQ(report.invalid_runs[1].sample, 5U);
  EXPECT_EQ(report.invalid_runs[1].amount, 3.0);
  EXPECT_EQ(report.jumps.size(), 1U);
  EXPECT_EQ(report.num_frozen, 10U);
  EXPECT_THAT(Describe(report, "probe"),
              ElementsAre(HasSubstr("1 jump faster"), HasSubstr("together 5 of 20 samples")));
}

TEST(Integrity, CountsRepeatedStampsAndTimeThatGoesBack) {
  PoseStream stream = Steady(10, 1'000'000);
  stream[4].time_ns = stream[3].time_ns;
  stream[8].time_ns = stream[7].time_ns - 1;
  EXPECT_EQ(CheckIntegrity(stream).num_repeated, 2U);
  EXPECT_THAT(Describe(CheckIntegrity(stream), "needle"), ElementsAre(HasSubstr("2 samples")));
}

TEST(Integrity, DoesNotTakeTheNoiseOfAToolAtRestForMetres) {
  PoseStream stream;
  RandomStream random(1, "at rest");
  for (int i = 0; i <= 600; ++i) {
    PoseSample sample{.time_ns = i * std::int64_t{10'000'000}};
    sample.reference_from_tool = Eigen::Isometry3d(
        Eigen::Translation3d(0.1 * random.Normal(), 0.1 * random.Normal(), 0.1 * random.Normal()));
    stream.push_back(sample);
  }
  EXPECT_TRUE(Describe(CheckIntegrity(stream), "needle").empty());
}

TEST(Integrity, ReportsOfCoordinatesThatSeemToBeInMetres) {
  const auto sweep = [](double extent) {
    PoseStream stream;
    for (int i = 0; i <= 300; ++i) {
      PoseSample sample{.time_ns = i * std::int64_t{10'000'000}};
      sample.reference_from_tool =
          Eigen::Isometry3d(Eigen::Translation3d(0.2, 0.1, extent * i / 300.0));
      stream.push_back(sample);
    }
    return Describe(CheckIntegrity(stream), "needle");
  };
  const auto in_metres = sweep(0.08);
  ASSERT_EQ(in_metres.size(), 1U);
  EXPECT_NE(in_metres[0].find("metres"), std::string::npos);
  EXPECT_TRUE(sweep(80.0).empty());
  EXPECT_TRUE(sweep(0.0).empty());   // It lies still.
  EXPECT_TRUE(sweep(0.03).empty());  // And trembles.
}

TEST(Integrity, LooksThroughEmptyAndSingleStreams) {
  EXPECT_EQ(CheckIntegrity({}).num_samples, 0U);
  EXPECT_TRUE(CheckIntegrity(Steady(1, 1)).clean());
}

TEST(Integrity, RefusesLimitsOutOfRange) {
  const auto expect = [](const IntegrityLimits& limits, const char* name) {
    EXPECT_THAT([&] { CheckIntegrity({}, limits); }, ThrowsMessage<InputError>(HasSubstr(name)));
  };
  expect({.gap_s = 0.0}, "gap_s");
  expect({.gap_intervals = 0.99}, "gap_intervals");
  expect({.jump_mm = -1.0}, "jump_mm");
  expect({.speed_mm_per_s = 0.0}, "speed_mm_per_s");
  expect({.jitter_mm = std::nan("")}, "jitter_mm");
}

TEST(Integrity, ASwapOfHandsIsNoJump) {
  PoseStream stream;
  for (int i = 0; i < 100; ++i) {
    PoseSample sample;
    sample.time_ns = i * 1'000'000;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = i < 50 ? 0.1 * i : 200.0 + 0.1 * i;
    sample.reference_from_tool = transforms::Pose(pose);
    stream.push_back(sample);
  }
  EXPECT_EQ(CheckIntegrity(stream).jumps.size(), 1U);
  const std::vector<Command> swapped = {{50'000'000, CommandKind::kSwapHands, 0.0}};
  EXPECT_TRUE(CheckIntegrity(stream, {}, swapped).jumps.empty());
  const std::vector<Command> later = {{51'000'000, CommandKind::kSwapHands, 0.0},
                                      {50'000'000, CommandKind::kFreezeImage, 0.0}};
  EXPECT_EQ(CheckIntegrity(stream, {}, later).jumps.size(), 1U);
}

}  // namespace
}  // namespace acus::session
