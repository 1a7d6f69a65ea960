// A step of the bendable needle must leave the hand's millisecond to others.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/needle/bendable_needle.h"
#include "acus/physics/needle/curved_path.h"
#include "acus/physics/needle/path_coupling.h"
#include "acus/physics/needle/rod.h"
#include "support/bending_scene.h"

namespace acus::needle {
namespace {

// Measured 9 to 10 us (2.6 GHz). The whole force step may take 50 us.
TEST(NeedleSpeed, AStepWithTwentyFiveNodesTakesMicroseconds) {
  RodProperties properties;
  properties.length_mm = 150.0;
  properties.bending_n_mm2 = 43400.0;
  properties.twist_n_mm2 = 33400.0;
  const RodModel model(properties, {.num_nodes = 25});
  RodState state = model.NewState();
  PathNode tissue;
  tissue.stiffness_n_per_mm2 = 0.1;
  CurvedPath path;
  path.Begin(tissue);
  path.Advance(Eigen::Vector3d::UnitZ(), 60.0, tissue);
  std::vector<RodContact> contacts(26);
  std::vector<double> times_us;
  for (int i = 0; i < 5000; ++i) {
    const double t = 1e-3 * i;
    const double begin = ThreadCpuSeconds();
    const int count = CoupleToPath(model, path, {}, contacts);
    RodInput input;
    input.contacts = {contacts.data(), static_cast<std::size_t>(count)};
    input.base.position_mm = {4.0 * std::sin(3.0 * t), 5.0 * std::sin(2.1 * t), -90.0};
    ASSERT_TRUE(model.Solve(state, input).converged());
    times_us.push_back(1e6 * (ThreadCpuSeconds() - begin));
  }
  const double median_us = math::Median(times_us);
  EXPECT_LT(median_us, 25.0);
  RecordProperty("median_us", std::to_string(median_us));
}

// Measured 10 us: with the path, the hub on springs, and the hand's force.
TEST(NeedleSpeed, AWholeStepInAHandTakesMicroseconds) {
  RodProperties properties;
  properties.length_mm = 150.0;
  properties.bending_n_mm2 = 43400.0;
  properties.twist_n_mm2 = 33400.0;
  const BendableNeedle needle(properties, {});
  BendableNeedleState state = needle.NewState();
  std::vector<double> times_us;
  BendableNeedleInput input;
  input.touches = true;
  input.tissue.stiffness_n_per_mm2 = 0.1;
  for (int i = 0; i < 5000; ++i) {
    const double t = 1e-3 * i;
    input.advance_mm = i < 1000 ? 0.06 : 0.03 * std::cos(2.0 * t);
    input.tip_mm.z() += input.advance_mm;
    input.hand = Eigen::AngleAxisd(0.1 * std::sin(2.5 * t), Eigen::Vector3d::UnitX());
    const double begin = ThreadCpuSeconds();
    ASSERT_TRUE(needle.Step(state, input).rod.converged()) << i;
    times_us.push_back(1e6 * (ThreadCpuSeconds() - begin));
  }
  const double median_us = math::Median(times_us);
  EXPECT_LT(median_us, 25.0);
  RecordProperty("median_us", std::to_string(median_us));
}

/// Median of one whole step: tissue contact or the axial model, and a rod of 25 nodes, in and out
/// of layers while the hand leans.
double MedianStepUs(scenario::NeedleForceModelKind force) {
  testing_support::BendingScene bending;
  bending.force = force;
  bending.tissue = nullptr;
  const simulation::Scene scene = bending.Make();
  const simulation::Simulation simulation(scene);
  simulation::State state = simulation.NewState();
  std::vector<double> times_us;
  for (int i = 0; i < 6000; ++i) {
    const double t = 1e-3 * i;
    const double depth_mm = i < 1000 ? 0.045 * i - 2.0 : 43.0 + 8.0 * std::sin(2.0 * t - 2.0);
    const simulation::Sample sample = testing_support::NeedleAt(
        t, {std::sin(3.0 * t), std::cos(2.1 * t), depth_mm}, {0.1 * std::sin(2.5 * t), 0.05, 0.0});
    const double begin = ThreadCpuSeconds();
    const simulation::StepOutput out = simulation.Step(state, sample);
    const double us = 1e6 * (ThreadCpuSeconds() - begin);
    if (out.shape.bent) times_us.push_back(us);
  }
  EXPECT_GT(times_us.size(), 5000u);
  return math::Median(times_us);
}

// Measured 11 us with either (2.6 GHz, busy machine). The whole force step may take 50 us.
TEST(NeedleSpeed, AFullStepOfASceneTakesMicroseconds) {
  const double layered_us = MedianStepUs(scenario::NeedleForceModelKind::kLayered);
  const double springs_us = MedianStepUs(scenario::NeedleForceModelKind::kTissue);
  std::printf("  layered and rod %.1f us, springs and rod %.1f us\n", layered_us, springs_us);
  EXPECT_LT(layered_us, 50.0);
  EXPECT_LT(springs_us, 50.0);
}

}  // namespace
}  // namespace acus::needle
