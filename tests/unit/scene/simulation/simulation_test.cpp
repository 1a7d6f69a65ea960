#include "acus/scene/simulation/simulation.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/math/rigid.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "support/allocation_counter.h"
#include "support/layered_scene.h"

namespace acus::simulation {
namespace {

using testing_support::LayeredScene;
using testing_support::PlanOf;

constexpr std::int64_t kSimulationMs = 1'000'000;

/// Straight down at 20 mm/s from 5 mm above the skin, at (x, y).
Sample SimulationInserting(int ms, double x_mm, double y_mm) {
  Sample sample{.time_ns = ms * kSimulationMs, .needle_valid = true};
  sample.reference_from_needle.translation() << x_mm, y_mm, -5.0 + 0.02 * ms;
  return sample;
}

/// On the skin, image plane y = 0, beam along +z.
Eigen::Isometry3d ProbeOnSkin() {
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  ct_from_probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return ct_from_probe;
}

bool SimulationSameBits(const StepOutput& a, const StepOutput& b) {
  return a.time_ns == b.time_ns && a.tissue_at_tip == b.tissue_at_tip &&
         a.force.force_in_ct_n == b.force.force_in_ct_n && a.force.AxialN() == b.force.AxialN() &&
         a.force.depth_mm == b.force.depth_mm && a.force.event == b.force.event;
}

TEST(LabelAt, IsTheNearestVoxelAndOutsideBeyond) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Eigen::Affine3d index_from_ct = scene.labels->geometry.index_from_ct();
  const auto at = [&](double x, double y, double z) {
    return volume::LabelAt(*scene.labels, index_from_ct, {x, y, z});
  };
  EXPECT_EQ(at(0, 0, -1.0), 0);
  EXPECT_EQ(at(0, 0, 5.0), volume::LabelOf("fat"));
  EXPECT_EQ(at(0, 20, 70.0), volume::LabelOf("bone"));
  EXPECT_EQ(at(0, 0, 70.0), volume::LabelOf("muscle"));
  EXPECT_EQ(at(0, 0, 1e300), 0);
  EXPECT_EQ(at(std::nan(""), 0, 5.0), 0);
  EXPECT_EQ(at(-std::numeric_limits<double>::infinity(), 0, 5.0), 0);
}

TEST(Step, MeetsTheLayersInOrderAndPushesTheNeedleOut) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Simulation simulation(scene);
  State state;
  double largest_n = 0.0;
  for (int ms = 0; ms < 2500; ++ms) {
    const StepOutput out = simulation.Step(state, SimulationInserting(ms, 0.0, 0.0));
    const double z_mm = -5.0 + 0.02 * ms;
    if (z_mm < -1.0) {
      EXPECT_EQ(out.force.force_in_ct_n.norm(), 0.0);
    }
    largest_n = std::max(largest_n, out.force.AxialN());
  }
  EXPECT_GT(largest_n, 0.1);
  EXPECT_LT(largest_n, 20.0);
}

TEST(Step, StopsAtBone) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Simulation simulation(scene);
  State state;
  StepOutput out;
  for (int ms = 0; ms < 3500; ++ms)
    out = simulation.Step(state, SimulationInserting(ms, 0.0, 20.0));
  EXPECT_GT(out.force.bone_n, 1.0);
  EXPECT_NEAR(out.force.depth_mm, 60.0, 1.0);  // The device is 5 mm beyond.
}

TEST(Step, GivesTheSameBitsAgainAndFromASavedState) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Simulation simulation(scene);
  State a;
  State saved;
  std::vector<StepOutput> first;
  for (int ms = 0; ms < 3000; ++ms) {
    if (ms == 1500) saved = a;
    first.push_back(simulation.Step(a, SimulationInserting(ms, 0.3, 0.2)));
  }
  StageTimes times(scene.plan);
  for (int ms = 1500; ms < 3000; ++ms) {
    ASSERT_TRUE(
        SimulationSameBits(first[static_cast<std::size_t>(ms)],
                           simulation.Step(saved, SimulationInserting(ms, 0.3, 0.2), &times)));
  }
  EXPECT_EQ(times.Of(scene.plan.WriterOf(effects::ports::kForce)).runs, 1500);
}

TEST(Step, AllocatesNothing) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Simulation simulation(scene);
  State state;
  const long before = testing_support::num_allocations.load();
  for (int ms = 0; ms < 3000; ++ms) simulation.Step(state, SimulationInserting(ms, 0.0, 20.0));
  EXPECT_EQ(testing_support::num_allocations.load() - before, 0);
}

TEST(Step, StaysFiniteWhateverTheTrackerSays) {
  const Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const Simulation simulation(scene);
  State state;
  for (int ms = 0; ms < 2000; ++ms) {
    Sample sample = SimulationInserting(ms, 0.0, 20.0);
    if (ms % 7 == 0) sample.reference_from_needle.translation()[ms % 3] = std::nan("");
    if (ms % 11 == 0) sample.time_ns -= 50 * kSimulationMs;
    if (ms % 13 == 0) sample.reference_from_needle.translation() *= 1e12;
    if (ms % 17 == 0) sample.needle_valid = false;
    if (ms % 19 == 0) sample.reference_from_needle.linear().setZero();
    const StepOutput out = simulation.Step(state, sample);
    ASSERT_TRUE(out.force.force_in_ct_n.allFinite()) << ms;
    ASSERT_LE(out.force.force_in_ct_n.norm(), scene.forces->table().settings.largest_force_n);
  }
}

TEST(Effects, OffAndOnButInactiveGiveIdenticalBits) {
  // The needle is far from the image; the needle force has nothing to touch.
  const Scene off = LayeredScene(PlanOf(false, true, true, false), false);
  const Scene on = LayeredScene(PlanOf(true, true, true, true), true);
  Snapshot snapshot{.probe_valid = true, .ct_from_probe = ProbeOnSkin()};
  ProbeImages without;
  ProbeImageRenderer(off).Render(snapshot, without);
  snapshot.ct_from_needle = Eigen::Translation3d(0, 25, -200) * Eigen::Isometry3d::Identity();
  ProbeImages inactive;
  ProbeImageRenderer(on).Render(snapshot, inactive);
  EXPECT_EQ(without.b_mode.pixels, inactive.b_mode.pixels);
  EXPECT_EQ(without.ct_slice.pixels, inactive.ct_slice.pixels);

  State state;
  const StepOutput step = Simulation(on).Step(state, SimulationInserting(0, 0.0, 0.0));
  State state_off;
  EXPECT_TRUE(
      SimulationSameBits(step, Simulation(off).Step(state_off, SimulationInserting(0, 0.0, 0.0))));

  // And it does show when it is there: the comparison above could fail.
  snapshot.ct_from_needle = Eigen::Translation3d(0, 0, 20) * Eigen::Isometry3d::Identity();
  ProbeImages shown;
  ProbeImageRenderer(on).Render(snapshot, shown);
  EXPECT_NE(without.ct_slice.pixels, shown.ct_slice.pixels);
  EXPECT_NE(without.b_mode.pixels, shown.b_mode.pixels);
}

/// A scene whose images show tissue moved by displacement functions.
Scene SceneWithMovedTissue(bool moved) {
  scenario::Scenario s;
  s.patient.ct = "ct";
  s.patient.labels = "labels";
  s.needle_force.emplace();
  s.ultrasound.emplace();
  s.ct_slice.emplace();
  if (moved) s.tissue.emplace().model = scenario::TissueModelKind::kDisplacementFunctions;
  Scene scene = LayeredScene(PlanEffects(s, {.needle_poses = true, .probe_poses = true}), false);
  if (moved) {
    scene.tissue.emplace(
        tissue::DisplacementFunctions({}, [](const Eigen::Vector3d&) { return 0.02; }));
    scene.tools_deform_images = true;
    scene.warp_spacing_mm = 2.0;
  }
  return scene;
}

TEST(Effects, TissueThatNothingDeformsGivesTheBitsOfOneThatIsOff) {
  const Scene on = SceneWithMovedTissue(true);
  const Scene off = SceneWithMovedTissue(false);
  Snapshot snapshot{.probe_valid = true, .ct_from_probe = ProbeOnSkin()};
  ProbeImages without, inactive, touched, shown;
  ProbeImageRenderer(off).Render(snapshot, without);
  ProbeImageRenderer renderer(on);
  renderer.Render(snapshot, inactive);
  EXPECT_EQ(without.b_mode.pixels, inactive.b_mode.pixels);
  EXPECT_EQ(without.ct_slice.pixels, inactive.ct_slice.pixels);

  const tissue::TissueLoad nothing;
  snapshot.load = &nothing;
  renderer.Render(snapshot, touched);
  EXPECT_EQ(without.b_mode.pixels, touched.b_mode.pixels);
  EXPECT_EQ(without.ct_slice.pixels, touched.ct_slice.pixels);

  // And with the needle in the tissue, the images do change: the comparisons above could fail.
  const Simulation simulation(on);
  State state = simulation.NewState();
  StepOutput out;
  tissue::TissueLoad load;
  for (int ms = 0; ms < 250; ++ms) out = simulation.Step(state, SimulationInserting(ms, 0.0, 0.0));
  EXPECT_FALSE(simulation.LoadOf(state, out, load));  // Not at the skin yet.
  for (int ms = 250; ms < 1200; ++ms)
    out = simulation.Step(state, SimulationInserting(ms, 0.0, 0.0));
  ASSERT_TRUE(simulation.LoadOf(state, out, load));
  snapshot.load = &load;
  renderer.Render(snapshot, shown);
  EXPECT_NE(without.b_mode.pixels, shown.b_mode.pixels);
  EXPECT_NE(without.ct_slice.pixels, shown.ct_slice.pixels);
  // The same moment again gives the same bits, whatever was rendered between.
  ProbeImages again;
  snapshot.load = nullptr;
  renderer.Render(snapshot, again);
  EXPECT_EQ(without.b_mode.pixels, again.b_mode.pixels);
  snapshot.load = &load;
  ProbeImageRenderer(on).Render(snapshot, again);
  EXPECT_EQ(shown.b_mode.pixels, again.b_mode.pixels);
}

TEST(ProbeImageRenderer, AllocatesNothingForMovedTissueAfterTheFirstImage) {
  const Scene scene = SceneWithMovedTissue(true);
  const Simulation simulation(scene);
  State state = simulation.NewState();
  StepOutput out;
  for (int ms = 0; ms < 1200; ++ms) out = simulation.Step(state, SimulationInserting(ms, 0.0, 0.0));
  tissue::TissueLoad load;
  ASSERT_TRUE(simulation.LoadOf(state, out, load));
  Snapshot snapshot{.probe_valid = true, .ct_from_probe = ProbeOnSkin(), .load = &load};
  ProbeImageRenderer renderer(scene);
  ProbeImages images;
  renderer.Render(snapshot, images);
  const long before = testing_support::num_allocations.load();
  for (int i = 0; i < 3; ++i) renderer.Render(snapshot, images);
  EXPECT_EQ(testing_support::num_allocations.load() - before, 0);
}

TEST(ProbeImageRenderer, IsBlackWhereTheProbeIsNotSeen) {
  const Scene scene = LayeredScene(PlanOf(false, true, true, false), false);
  ProbeImageRenderer renderer(scene);
  ProbeImages images;
  renderer.Render({.probe_valid = true, .ct_from_probe = ProbeOnSkin()}, images);
  EXPECT_GT(*std::ranges::max_element(images.b_mode.pixels), 0);
  renderer.Render({.probe_valid = false}, images);
  EXPECT_EQ(*std::ranges::max_element(images.b_mode.pixels), 0);
  EXPECT_EQ(*std::ranges::max_element(images.ct_slice.pixels), 0);
}

}  // namespace
}  // namespace acus::simulation
