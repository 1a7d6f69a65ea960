#include "acus/physics/tissue/needle_contact.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using forces::NeedleEvent;
using forces::NeedleForce;
using testing_support::FemScene;
using testing_support::SceneOptions;

SceneOptions NeedleContactLayers() {
  SceneOptions options;
  options.inner_below_mm = 30.0;
  options.bone_below_mm = 10.0;
  return options;
}

TEST(FemNeedle, PressesPuncturesCutsAndSlides) {
  FemScene scene(NeedleContactLayers());
  std::vector<NeedleEvent> events;
  double skin_n = 0.0;
  double inner_n = 0.0;
  for (int step = -10; step <= 540; ++step) {
    const NeedleForce force = scene.StepAt(0.1 * step);
    if (force.event != NeedleEvent::kNone) events.push_back(force.event);
    if (scene.state.phase == NeedlePhase::kOnSkin) {
      // It indents the skin as a spring and grows with every step.
      EXPECT_GE(force.puncture_n, skin_n);
      skin_n = force.puncture_n;
    } else if (force.depth_mm > 20.0) {
      inner_n = std::max(inner_n, force.puncture_n + force.cutting_n);
    }
    if (force.depth_mm > 12.0 && force.depth_mm < 29.0) {
      EXPECT_NEAR(force.cutting_n, 0.5, 1e-12);  // Of tissue 4.
      EXPECT_EQ(force.puncture_n, 0.0);
    }
  }
  EXPECT_NEAR(skin_n, 1.5, 0.05);
  EXPECT_NEAR(inner_n, 1.2, 1e-9);
  const std::vector<NeedleEvent> expected{NeedleEvent::kContact, NeedleEvent::kPuncture,
                                          NeedleEvent::kInterface, NeedleEvent::kPuncture,
                                          NeedleEvent::kBoneContact};
  EXPECT_EQ(events, expected);
  EXPECT_EQ(scene.state.num_out_of_reach, 0);
  EXPECT_TRUE(scene.state.end_is_bone);
  EXPECT_GT(scene.state.held.bone_n, 5.0);
  EXPECT_NEAR(scene.state.end_mm.z(), 10.0, 2.0);  // Jittered nodes around 10.
}

TEST(FemNeedle, FrictionGrowsWithTheShaftInEachTissue) {
  FemScene scene(NeedleContactLayers());
  scene.Move(-1.0, 15.0);
  const double at_15 = scene.Move(15.0, 16.0).friction_n;
  const double at_26 = scene.Move(16.0, 26.0).friction_n;
  EXPECT_NEAR(at_26 - at_15, 10.0 * 0.02, 0.01);
  const double at_38 = scene.Move(26.0, 38.0).friction_n;
  const double at_44 = scene.Move(38.0, 44.0).friction_n;
  EXPECT_NEAR(at_44 - at_38, 6.0 * 0.03, 0.01);
}

TEST(FemNeedle, AReversalTurnsFrictionRoundAndLeavingEndsAllForce) {
  FemScene scene(NeedleContactLayers());
  const double in_n = scene.Move(-1.0, 26.0).friction_n;
  const double out_n = scene.Move(26.0, 20.0).friction_n;
  EXPECT_GT(in_n, 0.4);
  EXPECT_NEAR(out_n, -in_n, 0.15 * in_n);
  NeedleForce force = scene.Move(20.0, -3.0);
  EXPECT_EQ(scene.state.phase, NeedlePhase::kFree);
  EXPECT_EQ(force.force_in_ct_n, Eigen::Vector3d::Zero());
  EXPECT_EQ(scene.state.contact.num_points(), 0);
}

TEST(FemNeedle, ReinsertionAlongTheChannelCutsNothingUpToItsEnd) {
  FemScene scene(NeedleContactLayers());
  scene.Move(-1.0, 25.0);
  const Eigen::Vector3d end_mm = scene.state.end_mm;
  scene.Move(25.0, -2.0);
  double largest_n = 0.0;
  for (int step = -20; step <= 150; ++step) {
    const NeedleForce force = scene.StepAt(0.1 * step);
    largest_n = std::max(largest_n, force.cutting_n + force.puncture_n);
  }
  EXPECT_EQ(largest_n, 0.0);
  EXPECT_EQ(scene.state.end_mm, end_mm);
  EXPECT_NEAR(scene.Move(15.0, 28.0).cutting_n, 0.5, 1e-12);  // Beyond the end it cuts again.
}

// Without friction the tissue is at rest while the needle is drawn back: the tip meets the capsule
// again where its cut ends.
TEST(FemNeedle, DrawnBackFromACapsuleItMeetsItWhereItIs) {
  SceneOptions options;
  options.inner_below_mm = 40.0;
  options.friction = 0.0;
  FemScene scene(options);
  scene.Move(0.0, 16.0);
  double depth_mm = 16.0;
  while (scene.StepAt(depth_mm += 0.05).event != NeedleEvent::kInterface) {
    ASSERT_LT(depth_mm, 40.0);
  }
  EXPECT_GT(scene.Move(depth_mm, depth_mm + 0.4).puncture_n, 0.1);
  scene.Move(depth_mm + 0.4, depth_mm - 6.0);
  depth_mm -= 6.0;
  NeedleForce force;
  while (force.cutting_n + force.puncture_n < 1e-3 && depth_mm < 40.0) {
    force = scene.StepAt(depth_mm += 0.02);
  }
  EXPECT_NEAR(depth_mm, (scene.state.end_mm - scene.state.entry_mm).norm(), 0.05);
}

TEST(FemNeedle, EntryElsewherePuncturesAgain) {
  FemScene scene(NeedleContactLayers());
  scene.Move(-1.0, 15.0);
  scene.Move(15.0, -2.0);
  double largest_n = 0.0;
  bool punctured = false;
  for (int step = -20; step <= 100; ++step) {
    const NeedleForce force = scene.StepAt(0.1 * step, 9.0, 4.0);
    largest_n = std::max(largest_n, force.puncture_n);
    punctured = punctured || force.event == NeedleEvent::kPuncture;
  }
  EXPECT_TRUE(punctured);
  EXPECT_NEAR(largest_n, 1.5, 0.05);
}

TEST(FemNeedle, PushedAsideItPushesBack) {
  FemScene scene(NeedleContactLayers());
  scene.Move(-1.0, 20.0);
  const NeedleForce before = scene.StepAt(20.0);
  NeedleForce force;
  for (int step = 1; step <= 20; ++step) force = scene.StepAt(20.0, 0.3 + 0.1 * step);
  EXPECT_LT(force.force_in_ct_n.x(), before.force_in_ct_n.x() - 0.05);
  EXPECT_NEAR(force.lateral_n, force.force_in_ct_n.head<2>().norm(), 1e-9);
  // Twice as far, twice the force: the tissue is linear, and the points stay where they are. But
  // for what friction does as points move along.
  const double once = force.force_in_ct_n.x() - before.force_in_ct_n.x();
  for (int step = 21; step <= 40; ++step) force = scene.StepAt(20.0, 0.3 + 0.1 * step);
  EXPECT_NEAR((force.force_in_ct_n.x() - before.force_in_ct_n.x()) / once, 2.0, 0.05);
}

TEST(FemNeedle, TheLoadOnTheTissueIsTheForceOnTheNeedle) {
  SceneOptions options = NeedleContactLayers();
  FemScene scene(options);
  TissueLoad load;
  for (int step = -10; step <= 400; ++step) {
    const NeedleForce force = scene.StepAt(0.1 * step, 0.3, -0.7, 0.05);
    // The load is of the state after the step, in which points can have been set or dropped.
    if (step % 20 != 0) continue;
    scene.model.LoadOf(scene.state, load);
    Eigen::Vector3d sum_n = Eigen::Vector3d::Zero();
    for (int p = 0; p < load.num_points; ++p) {
      sum_n += load.point[static_cast<std::size_t>(p)].force_in_ct_n;
    }
    EXPECT_LT((sum_n + force.force_in_ct_n).norm(), 1e-9) << step;
    EXPECT_EQ(load.needle.in_contact, step >= 0) << step;
  }
  EXPECT_TRUE(load.needle.pierced);
  EXPECT_GT(load.needle.friction_n, 0.0);
}

TEST(FemNeedle, BadSamplesAreHeldAndCounted) {
  FemScene scene(NeedleContactLayers());
  const NeedleForce good = scene.Move(-1.0, 15.0);
  ToolSample sample;
  sample.time_s = scene.time_s;  // Not later.
  sample.tip_in_ct_mm = {0.3, -0.7, 45.0};
  sample.axis_in_ct = {0, 0, -1};
  EXPECT_EQ(scene.model.Step(scene.state, sample).friction_n, good.friction_n);
  EXPECT_EQ(scene.state.num_time_back, 1);
  sample.time_s += 1e-3;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& tip : {Eigen::Vector3d(nan, 0, 0), Eigen::Vector3d(1e9, 0, 0)}) {
    sample.time_s += 1e-3;
    ToolSample bad = sample;
    bad.tip_in_ct_mm = tip;
    EXPECT_EQ(scene.model.Step(scene.state, bad).force_in_ct_n, Eigen::Vector3d::Zero());
  }
  ToolSample no_axis = sample;
  no_axis.time_s += 1e-3;
  no_axis.axis_in_ct.setZero();
  scene.model.Step(scene.state, no_axis);
  EXPECT_EQ(scene.state.num_rejected, 3);

  ToolSample lost = sample;
  lost.needle_valid = false;
  lost.time_s = scene.time_s + 0.05;
  EXPECT_EQ(scene.model.Step(scene.state, lost).friction_n, good.friction_n);
  lost.time_s = scene.time_s + 0.2;
  EXPECT_NEAR(scene.model.Step(scene.state, lost).friction_n, 0.5 * good.friction_n, 1e-9);
  lost.time_s = scene.time_s + 1.0;
  EXPECT_EQ(scene.model.Step(scene.state, lost).force_in_ct_n, Eigen::Vector3d::Zero());
  sample.time_s = lost.time_s + 1e-3;  // Found again where it was.
  EXPECT_NEAR(scene.model.Step(scene.state, sample).friction_n, good.friction_n, 0.02);
}

TEST(FemNeedle, ACopyOfTheStateContinuesWithTheSameBits) {
  FemScene scene(NeedleContactLayers());
  scene.Move(-1.0, 33.0);
  FemNeedleState copy = scene.state;
  const double time_s = scene.time_s;
  std::vector<NeedleForce> first;
  for (int step = 0; step < 300; ++step) {
    first.push_back(scene.StepAt(33.0 + 8.0 * std::sin(0.05 * step), 0.3, -0.7, 0.001 * step));
  }
  scene.state = copy;
  scene.time_s = time_s;
  for (int step = 0; step < 300; ++step) {
    const NeedleForce again =
        scene.StepAt(33.0 + 8.0 * std::sin(0.05 * step), 0.3, -0.7, 0.001 * step);
    ASSERT_EQ(again.force_in_ct_n, first[static_cast<std::size_t>(step)].force_in_ct_n) << step;
  }
}

TEST(FemNeedle, SaysWhatIsWrongWithItsInput) {
  const SceneOptions options;
  const mesh::TetraMesh mesh = testing_support::SceneMesh(options);
  const auto compliance = mechanics::Compliance::FromMatrix({200}, Eigen::Matrix3d::Identity(),
                                                            mechanics::Storage::kDouble);
  const auto make = [&](const mechanics::ElasticityTable& elastic, FemContactSettings settings) {
    return FemNeedleModel(mesh, compliance, elastic, testing_support::SceneForces(),
                          testing_support::SceneNeedle(), settings);
  };
  const auto good = testing_support::SceneElasticity(options);
  EXPECT_NO_THROW(make(good, {}));
  EXPECT_THROW(make(testing_support::ElasticLabels({{5, {0.01, 0.4}}}), {}), InputError);
  EXPECT_THROW(make(good, {.contact_spacing_mm = 0.0}), InputError);
  EXPECT_THROW(make(good, {.contact_spacing_mm = std::nan("")}), InputError);
  EXPECT_THROW(make(good, {.max_points = 1}), InputError);
  EXPECT_THROW(make(good, {.max_points = 129}), InputError);
}

}  // namespace
}  // namespace acus::tissue
