// A replay must be at least ten times faster than real time on two cores, with everything on.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/replay/replay.h"
#include "support/layered_scene.h"
#include "support/paired_times.h"
#include "support/slice_time.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;

constexpr double kSeconds = 30.0;

/// Voxels of 0.6 mm all around the image, so that no sample is cheap for lying outside.
volume::Geometry LargeGeometry() {
  volume::Geometry geometry;
  geometry.size = {256, 256, 280};
  geometry.spacing_mm = {0.6, 0.6, 0.6};
  geometry.origin_mm = {-76.5, -76.5, -9.7};
  return geometry;
}

/// In and out at 1 kHz, five times, under a probe that sways.
session::Session InAndOut() {
  session::Session session;
  for (int ms = 0; ms < static_cast<int>(1e3 * kSeconds); ++ms) {
    const double phase = 2.0 * std::numbers::pi * ms / 6000.0;
    const std::int64_t time_ns = ms * std::int64_t{1'000'000};
    const Eigen::Translation3d tip(0.0, 0.0, 20.0 - 28.0 * std::cos(phase));
    session.needle.push_back({time_ns, Eigen::Isometry3d(tip), true});
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    probe.rotate(Eigen::AngleAxisd(0.1 * std::sin(phase), Eigen::Vector3d::UnitY()));
    probe.translation() << 3.0 * std::sin(phase), 0.0, -0.5;
    session.probe.push_back({time_ns, probe, true});
  }
  return session;
}

/// Fast, but is it right? Everything was made, and the needle felt the tissue.
void ExpectAllWasMade(const fs::path& run_folder) {
  const auto run = config::ReadJson(run_folder / "run.json");
  EXPECT_EQ(run.at("images"), 900);
  const auto& stages = run.at("effect_plan");
  const auto force = std::ranges::find_if(
      stages, [](const auto& stage) { return stage.at("stage") == "needle force"; });
  ASSERT_NE(force, stages.end());
  EXPECT_EQ(force->at("runs"), 30'000);
  for (const auto& metric : config::ReadJson(run_folder / "metrics.json").at("metrics")) {
    if (metric.at("name") == "punctures") {
      EXPECT_GE(metric.at("value"), 5.0);
    }
    if (metric.at("name") == "largest axial force") {
      EXPECT_GT(metric.at("value"), 0.3);
      EXPECT_LT(metric.at("value"), 10.0);
    }
  }
}

// Ten times real time leaves two cores 6 s of CPU time: 1600 slices, where one takes 3.8 ms. CPU
// time, as others may use the machine. Measured 830 to 1180 slices; compressed sequences would
// cost 40 % more.
TEST(ReplaySpeed, ThirtySecondsTakeFifteenHundredSlices) {
  constexpr double kMostSlices = 1500.0;
  const fs::path folder = fs::path(testing::TempDir()) / "replay_speed_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  RunContext context;
  context.num_threads = 2;
  const auto scene = testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true),
                                                   true, LargeGeometry());
  volume::WriteCt(folder / "ct.nrrd", *scene.ct);
  volume::WriteLabelMap(folder / "labels.seg.nrrd", *scene.labels);
  session::WriteSession(folder / "session", InAndOut(), context);
  WriteTextFile(folder / "scene.json", R"({"format": "acus-scenario/1",
    "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, "probe": "probes/linear_l14.json",
    "effects": {"needle_force": {}, "ultrasound": {}, "ct_slice": {}}})");
  const auto scenario = scenario::ReadScenario(folder / "scene.json", {});

  testing_support::LeastTime replay;
  double slice_ms = 1e30;
  int runs = 0;
  const auto measure = [&] {
    slice_ms = std::min(slice_ms, testing_support::SliceCpuMs());
    ReplayOptions options;
    options.run_folder = folder / ("run" + std::to_string(runs++));
    replay.Add([&] { ReplaySession(scenario, folder / "session", options, context); });
    ExpectAllWasMade(options.run_folder);
  };
  const auto slices = [&] { return replay.cpu_ms / slice_ms; };
  testing_support::MeasureUntil(2, 6, measure, [&] { return slices() < kMostSlices; });
  const double speed = 2e3 * kSeconds / replay.cpu_ms;
  std::printf(
      "%.0f s replayed in %.2f s of CPU time: %.0f slices of %.2f ms; %.1f times real time "
      "on two cores\n",
      kSeconds, 1e-3 * replay.cpu_ms, slices(), slice_ms, speed);
  EXPECT_LT(slices(), kMostSlices);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace acus::replay
