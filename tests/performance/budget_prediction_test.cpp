// What a budget predicts from one session holds on another: within 20 % for the 99.9th percentile
// of steps and the 95th of images.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/assess/regression/calibration.h"
#include "acus/assess/tuning/budget.h"
#include "acus/assess/tuning/budget_scenario.h"
#include "acus/assess/tuning/case_run.h"
#include "acus/data/session/session_io.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

/// How a hand brings the needle in, at 1 kHz, under a probe that sways.
struct Hand {
  std::string name;
  double x_mm = 0.0;
  double angle_rad = 0.0;
  double speed_mm_per_s = 20.0;
  double depth_mm = 45.0;
  double sway_mm = 2.0;
  double sway_period_s = 3.0;
};

session::Session SessionOf(const Hand& hand) {
  constexpr int kMs = 6000;
  session::Session session;
  session.name = hand.name;
  const Eigen::AngleAxisd tilt(hand.angle_rad, Eigen::Vector3d::UnitX());
  for (int ms = 0; ms < kMs; ++ms) {
    // In, a rest, out again.
    const double in_s = (hand.depth_mm + 5.0) / hand.speed_mm_per_s;
    const double t = 1e-3 * ms;
    const double left_s = 1e-3 * kMs - t;
    const double along = std::min({1.0, t / in_s, left_s / in_s});
    session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = tilt.toRotationMatrix();
    pose.translation() =
        Eigen::Vector3d(hand.x_mm, 0.0, 0.0) +
        pose.linear() * Eigen::Vector3d(0.0, 0.0, (hand.depth_mm + 5.0) * along - 5.0);
    needle.reference_from_tool = pose;
    session.needle.push_back(needle);
    if (ms % 20 != 0) continue;
    const double phase = 2.0 * std::numbers::pi * t / hand.sway_period_s;
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    probe.rotate(Eigen::AngleAxisd(0.05 * std::sin(phase), Eigen::Vector3d::UnitY()));
    probe.translation() << hand.sway_mm * std::sin(phase), 0.0, -0.5;
    session.probe.push_back({needle.time_ns, probe, true});
  }
  return session;
}

/// The least of several runs of a scenario over a session.
scenario::Cost CostOn(const fs::path& scenario, const fs::path& session, RunContext& context) {
  scenario::Cost least;
  const auto keep = [](double& value, double now) {
    if (!(value <= now)) value = now;
  };
  for (int n = 0; n < 3; ++n) {
    SweptScene scene;
    scene.scenario = scenario;
    scene.session = session;
    scene.most_images = 16;
    const Measured run = RunCase(scene, {}, context).measured;
    keep(least.step_us_median, run.step_us_median);
    keep(least.step_us_p999, run.step_us_p999);
    keep(least.image_ms_median, run.image_ms_median);
    keep(least.image_ms_p95, run.image_ms_p95);
  }
  return least;
}

TEST(BudgetPrediction, HoldsOnASecondSession) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  RunContext context;
  testing_support::WriteLayeredFolder(folder, R"({"needle_force": {"model": "tissue"},
    "tissue": {"model": "springs"}, "needle": {"model": "bendable"},
    "ultrasound": {"model": "beams", "beams": {"elevation_planes": 3}}})");
  session::WriteSession(folder / "first", SessionOf({.name = "first"}), context);
  session::WriteSession(folder / "second",
                        SessionOf({.name = "second",
                                   .x_mm = 4.0,
                                   .angle_rad = 0.15,
                                   .speed_mm_per_s = 22.0,
                                   .depth_mm = 47.0,
                                   .sway_mm = 4.0,
                                   .sway_period_s = 2.2}),
                        context);
  SweepRequest request;
  request.scene.scenario = folder / "scene.json";
  request.scene.session = folder / "first";
  request.scene.most_images = 16;
  request.knobs = {"needle_nodes=15,25,50", "elevation_planes=1,3"};
  const SweepPlan plan = MakeBudgetPlan(request, context);

  // Others use the machine: a pair of measurements that they disturbed is taken again.
  double worst = 0.0;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const fs::path sweep = folder / Message("sweep_", attempt);
    const RunStore store(sweep, IdentityOf(plan), false);
    const double calibration_before_s = regression::CalibrationSeconds();
    // Half as much again as the scene takes as it is: some knobs may be turned up, not all.
    const scenario::Cost given = CostOn(folder / "scene.json", folder / "first", context);
    const Goal goal{.kind = GoalKind::kBudget,
                    .force = 1.5 * given.step_us_p999,
                    .image = 1.5 * given.image_ms_p95};
    const BudgetQuestion question{.goal = goal, .asked = "--budget " + TextOf(goal)};
    const BudgetAnswer answer = AnswerQuestion(question, plan, store, context);
    ASSERT_TRUE(answer.Found()) << AnswerText(answer);
    WriteChosenScenario(sweep / "scenario.json", answer);
    const auto scenario = scenario::ReadScenario(sweep / "scenario.json", {});
    ASSERT_TRUE(scenario.evidence.has_value());
    const scenario::Cost& predicted = scenario.evidence->measured;

    const double calibration_after_s = regression::CalibrationSeconds();
    const scenario::Cost measured = CostOn(sweep / "scenario.json", folder / "second", context);
    const double slower = calibration_after_s / calibration_before_s;
    std::printf("%sthe machine is %.2f times as slow as before\n", AnswerText(answer).c_str(),
                slower);
    worst = 0.0;
    // What budgets are about. The median of steps says how long a hand rests, not what a step
    // takes.
    for (const auto& [name, value] : {std::pair{"step, 99.9 % [us]", &scenario::Cost::step_us_p999},
                                      {"image, median [ms]", &scenario::Cost::image_ms_median},
                                      {"image, 95 % [ms]", &scenario::Cost::image_ms_p95}}) {
      const double ratio = measured.*value / (predicted.*value);
      std::printf("%-20s predicted %8.3f, measured on the second session %8.3f: ratio %.3f\n", name,
                  predicted.*value, measured.*value, ratio);
      worst = std::max(worst, std::abs(ratio - 1.0));
    }
    if (worst <= 0.2) break;
  }
  EXPECT_LE(worst, 0.2);
}

}  // namespace
}  // namespace acus::tuning
