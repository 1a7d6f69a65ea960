#include "acus/run/training/handling_metrics.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/run/training/smoothness.h"

namespace acus::training {
namespace {

/// exp(-5 t^2) for t from -1 to 1 at 100 Hz.
std::vector<double> Bump() {
  std::vector<double> speed;
  for (int i = 0; i < 200; ++i) speed.push_back(std::exp(-5.0 * std::pow(-1.0 + 0.01 * i, 2)));
  return speed;
}

/// The values that the reference implementation of the paper's authors states for this movement.
TEST(Smoothness, GivesThePublishedValuesOfABellShapedMovement) {
  EXPECT_NEAR(SpectralArcLength(Bump(), 100.0), -1.41403, 1e-5);
  EXPECT_NEAR(LogDimensionlessJerk(Bump(), 100.0), -std::log(335.74684), 1e-7);
}

TEST(Smoothness, DoesNotDependOnSizeAndFallsWithEveryStop) {
  std::vector<double> twice = Bump(), with_stop = Bump();
  for (double& v : twice) v *= 2.0;
  for (std::size_t i = 0; i < with_stop.size(); ++i) {
    with_stop[i] *= 1.0 - 0.9 * std::exp(-std::pow((static_cast<double>(i) - 100.0) / 15.0, 2));
  }
  EXPECT_NEAR(SpectralArcLength(twice, 100.0), SpectralArcLength(Bump(), 100.0), 1e-12);
  EXPECT_NEAR(LogDimensionlessJerk(twice, 100.0), LogDimensionlessJerk(Bump(), 100.0), 1e-12);
  EXPECT_LT(SpectralArcLength(with_stop, 100.0), SpectralArcLength(Bump(), 100.0) - 0.1);
  EXPECT_LT(LogDimensionlessJerk(with_stop, 100.0), LogDimensionlessJerk(Bump(), 100.0) - 1.0);
}

TEST(Smoothness, KnowsNoFrequencyAboveHalfTheRate) {
  const std::vector<double> speed = {0.0, 3.0, 1.0, 4.0, 1.0, 5.0, 2.0, 0.0};
  EXPECT_EQ(SpectralArcLength(speed, 20.0, {.cutoff_hz = 19.0}),
            SpectralArcLength(speed, 20.0, {.cutoff_hz = 10.0}));
}

TEST(SpeedProfile, NeedsThreeSteps) {
  session::PoseStream stream;
  for (const std::int64_t time_ns : {0, 30'000'000}) {
    const Eigen::Translation3d at_mm(1e-6 * static_cast<double>(time_ns), 0.0, 0.0);  // 1 m/s.
    stream.push_back({time_ns, transforms::Pose(Eigen::Isometry3d(at_mm)), true});
  }
  const auto speed = SpeedProfile(stream, 0, 30'000'000, 100.0);
  ASSERT_EQ(speed.size(), 3U);
  for (const double mm_per_s : speed) EXPECT_NEAR(mm_per_s, 1000.0, 1e-6);
  EXPECT_TRUE(SpeedProfile(stream, 0, 29'000'000, 100.0).empty());
}

TEST(Smoothness, RestIsNoMovement) {
  const std::vector<double> rest(50, 0.0);
  EXPECT_EQ(SpectralArcLength(rest, 100.0), 0.0);
  EXPECT_EQ(LogDimensionlessJerk(rest, 100.0), 0.0);
}

/// 10 s at rest 60 mm outside, 2 s to the skin at 30 mm/s, 4 s to 40 mm at 10 mm/s, 3 s of rest;
/// the probe sways by 2 mm.
session::Session Trial() {
  session::Session session;
  for (int ms = 0; ms <= 19'000; ++ms) {
    const double t = 1e-3 * ms;
    const double z_mm = t < 10.0   ? -60.0
                        : t < 12.0 ? -60.0 + 30.0 * (t - 10.0)
                        : t < 16.0 ? 10.0 * (t - 12.0)
                                   : 40.0;
    const std::int64_t time_ns = ms * std::int64_t{1'000'000};
    session.needle.push_back(
        {time_ns, Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, z_mm)), true});
    session.probe.push_back(
        {time_ns,
         Eigen::Isometry3d(Eigen::Translation3d(2.0 * std::sin(2.0 * std::numbers::pi * t), 0, 0)),
         true});
  }
  return session;
}

bool BelowSkin(const Eigen::Vector3d& point_mm) {
  return point_mm.z() > 0.0;
}

TEST(FindPhases, FindsSearchAimAdvanceAndDepth) {
  const auto phases = FindPhases(Trial(), BelowSkin);
  ASSERT_TRUE(phases);
  EXPECT_EQ(phases->begin_ns, 0);
  EXPECT_NEAR(1e-9 * static_cast<double>(phases->aim_ns), 11.0, 0.002) << "30 mm before the skin";
  EXPECT_NEAR(1e-9 * static_cast<double>(phases->contact_ns), 12.0, 0.002);
  EXPECT_NEAR(1e-9 * static_cast<double>(phases->deepest_ns), 15.9, 0.002) << "1 mm before";
  EXPECT_NEAR(1e-9 * static_cast<double>(phases->end_ns), 19.0, 1e-9);
}

TEST(FindPhases, NeedsAPassInTissue) {
  session::Session session = Trial();
  session.needle.resize(11'000);
  EXPECT_FALSE(FindPhases(session, BelowSkin));
}

TEST(HandlingMetrics, ProbeWanderIsTheRmsOfItsSway) {
  volume::LabelMap labels;
  labels.geometry.size = {3, 3, 60};
  labels.geometry.origin_mm = {-1.0, -1.0, 0.5};
  labels.voxels.assign(labels.geometry.num_voxels(), 1);
  const auto metrics = HandlingMetricsOf(Trial(), {labels});
  const auto value = [&](const std::string& name) {
    for (const Metric& metric : metrics) {
      if (metric.name == name) return metric.value;
    }
    return std::nan("");
  };
  EXPECT_NEAR(value("probe wander during the advance"), 2.0 / std::sqrt(2.0), 0.05);
  EXPECT_NEAR(value("time of aiming"), 1.0, 0.01);
  EXPECT_NEAR(value("time of advance"), 3.9, 0.01);
  EXPECT_LT(value("needle smoothness, spectral arc length"), -1.0);
}

}  // namespace
}  // namespace acus::training
