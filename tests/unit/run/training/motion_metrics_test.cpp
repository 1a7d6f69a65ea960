#include "acus/run/training/motion_metrics.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::training {
namespace {

using session::PoseSample;
using session::PoseStream;
using transforms::Pose;

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Tissue fills the half space z < 0: the surface is the plane z = 0.
bool BelowSurface(const Eigen::Vector3d& point_mm) {
  return point_mm.z() < 0.0;
}

/// A needle that points straight down (-z of the reference), its tip at a point.
Pose DownAt(const Eigen::Vector3d& tip_mm) {
  return math::PoseFromAxes(tip_mm, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX());
}

PoseStream Tips(const std::vector<Eigen::Vector3d>& tips_mm, std::int64_t interval_ns) {
  PoseStream stream;
  for (std::size_t i = 0; i < tips_mm.size(); ++i) {
    stream.push_back({static_cast<std::int64_t>(i) * interval_ns, DownAt(tips_mm[i]), true});
  }
  return stream;
}

TEST(MotionMetrics, MeasuresACircle) {
  PoseStream stream;
  constexpr int kSteps = 3600;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSteps;
    stream.push_back({std::int64_t{i} * 100'000'000,
                      DownAt({20.0 * std::cos(angle), 20.0 * std::sin(angle), 0.0}), true});
  }
  const auto metrics = ComputeMotionMetrics(stream);
  // A polygon of n sides: 2 n r sin(pi / n).
  const double path_mm = 2.0 * kSteps * 20.0 * std::sin(std::numbers::pi / kSteps);
  EXPECT_NEAR(metrics.path_length_mm, path_mm, 1e-9);
  EXPECT_NEAR(metrics.elapsed_time_s, 360.0, 1e-12);
  EXPECT_NEAR(metrics.mean_speed_mm_per_s, path_mm / 360.0, 1e-9);
  EXPECT_NEAR(metrics.max_speed_mm_per_s, path_mm / 360.0, 1e-6);
}

TEST(MotionMetrics, TakesTheMaximumSpeedOverAWindow) {
  std::vector<Eigen::Vector3d> tips_mm;
  double x_mm = 0.0;
  for (int i = 0; i < 1000; ++i) {
    tips_mm.emplace_back(x_mm, i % 2 == 0 ? 0.0 : 1e-3, 0.0);
    x_mm += i >= 500 && i < 700 ? 0.3 : 0.1;  // 300 mm/s for 0.2 s, else 100.
  }
  const auto metrics = ComputeMotionMetrics(Tips(tips_mm, 1'000'000));
  EXPECT_NEAR(metrics.max_speed_mm_per_s, 300.0, 1e-4);
  // A window longer than the burst sees the mean over it.
  const auto wide = ComputeMotionMetrics(Tips(tips_mm, 1'000'000), {.speed_window_s = 0.4});
  EXPECT_NEAR(wide.max_speed_mm_per_s, 200.0, 0.01);
}

TEST(MotionMetrics, LeavesInvalidSamplesOut) {
  PoseStream stream =
      Tips({{0, 0, 0}, {99, 0, 0}, {0, 3, 0}, {4, 3, 0}, {50, 0, 0}}, 1'000'000'000);
  stream[1].valid = false;
  stream[4].valid = false;
  const auto metrics = ComputeMotionMetrics(stream);
  EXPECT_DOUBLE_EQ(metrics.path_length_mm, 7.0);
  EXPECT_DOUBLE_EQ(metrics.elapsed_time_s, 3.0);
}

TEST(MotionMetrics, AreZeroForFewerThanTwoValidSamples) {
  EXPECT_EQ(ComputeMotionMetrics({}).elapsed_time_s, 0.0);
  EXPECT_EQ(ComputeMotionMetrics(Tips({{1, 2, 3}}, 1)).mean_speed_mm_per_s, 0.0);
}

/// An advance by 40 mm into tissue in 20 s, sideways by as much, and 2 s of rest, with tremor of
/// 0.1 mm at 9 Hz in all directions and an angle that trembles, as read at a rate.
PoseStream TremblingAdvance(double rate_hz) {
  PoseStream stream;
  for (double t = 0.0; t <= 22.0; t += 1.0 / rate_hz) {
    const double phase = 2.0 * std::numbers::pi * 9.0 * t;
    const Eigen::Vector3d tremor(std::sin(1.13 * phase), std::sin(phase + 1.0),
                                 std::sin(0.91 * phase + 2.0));
    const Eigen::Vector3d down = (Eigen::Vector3d(0.002 * std::sin(phase), 0.0, -1.0)).normalized();
    const Eigen::Vector3d tip_mm =
        std::min(t, 20.0) * Eigen::Vector3d(2.0, 0.0, -2.0) + Eigen::Vector3d(0.0, 0.0, 2.0);
    stream.push_back({std::llround(1e9 * t),
                      math::PoseFromAxes(tip_mm + 0.1 * tremor, down, Eigen::Vector3d::UnitY()),
                      true});
  }
  return stream;
}

TEST(TissueMetrics, DoNotGrowWithTheRateOfSamples) {
  const auto of = [](double rate_hz) {
    return std::pair(ComputeMotionMetrics(TremblingAdvance(rate_hz)),
                     ComputeTissueMetrics(TremblingAdvance(rate_hz), BelowSurface));
  };
  const auto [motion, tissue] = of(10.0);
  for (const double rate_hz : {60.0, 1000.0}) {
    const auto [fast_motion, fast_tissue] = of(rate_hz);
    EXPECT_NEAR(fast_motion.path_length_mm, motion.path_length_mm, 0.03 * motion.path_length_mm);
    EXPECT_NEAR(fast_motion.max_speed_mm_per_s, motion.max_speed_mm_per_s,
                0.1 * motion.max_speed_mm_per_s);
    EXPECT_NEAR(fast_tissue.path_in_tissue_mm, tissue.path_in_tissue_mm,
                0.03 * tissue.path_in_tissue_mm);
    EXPECT_NEAR(fast_tissue.tissue_damage_mm2, tissue.tissue_damage_mm2,
                0.03 * tissue.tissue_damage_mm2);
    EXPECT_EQ(fast_tissue.num_insertions, tissue.num_insertions);
  }
}

TEST(TissueMetrics, CountUpToTheNewestSample) {
  // Two samples within 0.1 s.
  const auto stream = Tips({{0, 0, -10}, {3, 0, -10}}, 20'000'000);
  EXPECT_DOUBLE_EQ(ComputeMotionMetrics(stream).path_length_mm, 3.0);
  EXPECT_DOUBLE_EQ(ComputeTissueMetrics(stream, BelowSurface).path_in_tissue_mm, 3.0);
  EXPECT_NEAR(ComputeTissueMetrics(stream, BelowSurface).tissue_damage_mm2, 30.0, 1e-3);
}

TEST(TissueMetrics, CountAStepIfItsEndIsInTissue) {
  // Down 4 mm to 3 mm deep, up again: z = 1, -1, -3, -1, 1.
  const auto stream = Tips({{0, 0, 1}, {0, 0, -1}, {0, 0, -3}, {0, 0, -1}, {0, 0, 1}}, 500'000'000);
  const auto metrics = ComputeTissueMetrics(stream, BelowSurface);
  EXPECT_DOUBLE_EQ(metrics.time_in_tissue_s, 1.5);
  EXPECT_DOUBLE_EQ(metrics.path_in_tissue_mm, 6.0);
  EXPECT_EQ(metrics.num_insertions, 1);
  EXPECT_NEAR(metrics.tissue_damage_mm2, 0.0, 1e-5);  // Straight in and out cuts no area.
}

TEST(TissueMetrics, DamageIsTheAreaThatTheShaftSweeps) {
  // Sideways by 7 mm at 10 mm depth, upright: a rectangle.
  std::vector<Eigen::Vector3d> tips_mm;
  for (int i = 0; i <= 70; ++i) tips_mm.emplace_back(0.1 * i, 0.0, -10.0);
  EXPECT_NEAR(ComputeTissueMetrics(Tips(tips_mm, 1'000'000), BelowSurface).tissue_damage_mm2, 70.0,
              1e-3);
  // Turned by 60 degrees about an entry that stays, 20 mm along the shaft: a sector of the circle.
  PoseStream turned;
  constexpr int kSteps = 600;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = std::numbers::pi / 3.0 * (static_cast<double>(i) / kSteps - 0.5);
    const Eigen::Vector3d down(std::sin(angle), 0.0, -std::cos(angle));
    turned.push_back({std::int64_t{i} * 100'000'000,
                      math::PoseFromAxes(20.0 * down, down, Eigen::Vector3d::UnitY()), true});
  }
  const double sector_mm2 = 0.5 * 20.0 * 20.0 * std::numbers::pi / 3.0;
  EXPECT_NEAR(ComputeTissueMetrics(turned, BelowSurface).tissue_damage_mm2, sector_mm2, 1e-3);
}

TEST(TissueMetrics, CountsAnInsertionOnlyAfterAWithdrawal) {
  std::vector<Eigen::Vector3d> tips_mm = {{0, 0, 10}};
  for (int i = 0; i < 20; ++i) tips_mm.emplace_back(0, 0, i % 2 == 0 ? -0.2 : 0.2);  // Tremor.
  tips_mm.emplace_back(0, 0, 6);
  tips_mm.emplace_back(0, 0, -4);
  EXPECT_EQ(ComputeTissueMetrics(Tips(tips_mm, 1), BelowSurface).num_insertions, 2);
  EXPECT_EQ(
      ComputeTissueMetrics(Tips(tips_mm, 1), BelowSurface, {.withdrawal_mm = 0}).num_insertions,
      11);
}

TEST(TissueMetrics, AWithdrawalByExactlyTheLimitCounts) {
  // Out of the tissue from z = -1 by 5 mm, and in again.
  const auto stream = Tips({{0, 0, 1}, {0, 0, -1}, {0, 0, 1}, {0, 0, 4}, {0, 0, -1}}, 1);
  const auto insertions = [&](double withdrawal_mm) {
    return ComputeTissueMetrics(stream, BelowSurface, {.withdrawal_mm = withdrawal_mm})
        .num_insertions;
  };
  EXPECT_EQ(insertions(5.0), 2);
  EXPECT_EQ(insertions(5.001), 1);
}

TEST(ShaftExit, FindsTheSurfaceAndStopsAtTheHub) {
  const Eigen::Vector3d down = Eigen::Vector3d(1, 0, -1).normalized();
  const Eigen::Isometry3d needle = math::PoseFromAxes(Eigen::Vector3d(30, 5, -20), down, {0, 1, 0});
  EXPECT_LT((ShaftExit(needle, BelowSurface, 300.0) - Eigen::Vector3d(10, 5, 0)).norm(), 1e-6);
  const Eigen::Vector3d hub = needle.translation() - 8.3 * down;
  EXPECT_LT((ShaftExit(needle, BelowSurface, 8.3) - hub).norm(), 1e-12);
}

TEST(Metrics, RefuseOptionsOutOfRange) {
  const auto expect = [](const MetricOptions& options, const char* name) {
    EXPECT_THAT([&] { ComputeMotionMetrics({}, options); },
                ThrowsMessage<InputError>(HasSubstr(name)));
    EXPECT_THAT([&] { ComputeTissueMetrics({}, BelowSurface, options); },
                ThrowsMessage<InputError>(HasSubstr(name)));
  };
  expect({.speed_window_s = 0.0}, "speed_window_s");
  expect({.speed_window_s = INFINITY}, "speed_window_s");
  expect({.needle_length_mm = 0.0}, "needle_length_mm");
  expect({.needle_length_mm = 10001.0}, "needle_length_mm");
  expect({.withdrawal_mm = -0.1}, "withdrawal_mm");
  expect({.withdrawal_mm = INFINITY}, "withdrawal_mm");
}

}  // namespace
}  // namespace acus::training
