#include "acus/rig/tracking/simulators/tool_motion.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::simulators {
namespace {

constexpr std::int64_t kMs = 1'000'000;

session::PoseSample Sample(std::int64_t ms, double x_mm, bool valid = true) {
  return {.time_ns = ms * kMs,
          .reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(x_mm, 0.0, 0.0)),
          .valid = valid};
}

/// Starts at 1 s. The needle at 100 Hz for 50 ms, the probe at two instants, one between.
session::Session Recording() {
  session::Session session;
  session.name = "test";
  for (int i = 0; i <= 5; ++i) session.needle.push_back(Sample(1000 + 10 * i, i, i != 2));
  session.probe = {Sample(1010, 100.0), Sample(1035, 200.0)};
  return session;
}

std::vector<std::int64_t> Instants(const ToolMotion& motion, std::size_t most = 100) {
  std::vector<std::int64_t> all;
  for (auto at = motion.Next(-1); at && all.size() < most; at = motion.Next(*at)) {
    all.push_back(*at / kMs);
  }
  return all;
}
using Ms = std::vector<std::int64_t>;

TEST(RecordedMotion, PlaysEachReadingAtItsTime) {
  const auto motion = RecordedMotion(Recording(), {});
  EXPECT_EQ(motion->end_ns(), 50 * kMs);
  EXPECT_EQ(Instants(*motion), (Ms{0, 10, 20, 30, 35, 40, 50}));
  const auto both = motion->At(10 * kMs);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].name, "NeedleToReference");
  EXPECT_TRUE(both[0].reference_from_tool == Sample(0, 1.0).reference_from_tool);
  EXPECT_EQ(both[1].name, "ProbeToReference");
  EXPECT_FALSE(motion->At(20 * kMs)[0].valid);
  ASSERT_EQ(motion->At(35 * kMs).size(), 1u);
  EXPECT_EQ(motion->At(35 * kMs)[0].reference_from_tool.translation().x(), 200.0);
}

TEST(ResampledMotion, GivesAllToolsAtTheRate) {
  const auto motion = ResampledMotion(Recording(), {.needle = "N", .probe = "P"}, 200.0);
  EXPECT_EQ(Instants(*motion), (Ms{0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50}));
  const auto between = motion->At(45 * kMs);
  ASSERT_EQ(between.size(), 2u);
  EXPECT_EQ(between[0].name, "N");
  EXPECT_NEAR(between[0].reference_from_tool.translation().x(), 4.5, 1e-12);
  EXPECT_EQ(between[1].reference_from_tool.translation().x(), 200.0);
  EXPECT_FALSE(motion->At(25 * kMs)[0].valid) << "a neighbour was not seen";
  EXPECT_THROW(ResampledMotion(Recording(), {}, 0.05), InputError);
  EXPECT_THROW(ResampledMotion(Recording(), {}, 5001.0), InputError);
  EXPECT_THROW(ResampledMotion(Recording(), {}, NAN), InputError);
}

TEST(ForthAndBack, NeverJumpsAndNeverEnds) {
  const auto motion = ForthAndBack(RecordedMotion(Recording(), {}));
  EXPECT_FALSE(motion->end_ns().has_value());
  EXPECT_EQ(Instants(*motion, 16),
            (Ms{0, 10, 20, 30, 35, 40, 50, 60, 65, 70, 80, 90, 100, 110, 120, 130}));
  double last_mm = 0.0;
  int readings = 0;
  for (auto at = motion->Next(-1); readings < 100; at = motion->Next(*at)) {
    ASSERT_TRUE(at.has_value());
    for (const auto& pose : motion->At(*at)) {
      if (pose.name != "NeedleToReference") continue;
      const double x_mm = pose.reference_from_tool.translation().x();
      EXPECT_LE(std::abs(x_mm - last_mm), 1.0) << *at;
      last_mm = x_mm;
      ++readings;
    }
  }
}

TEST(ToolMotion, NeedsSomethingToPlay) {
  EXPECT_THROW(RecordedMotion({}, {}), InputError);
  session::Session instant;
  instant.needle = {Sample(0, 1.0)};
  EXPECT_EQ(Instants(*RecordedMotion(instant, {})), Ms{0});
  EXPECT_THROW(ForthAndBack(RecordedMotion(instant, {})), InputError);
}

}  // namespace
}  // namespace acus::simulators
