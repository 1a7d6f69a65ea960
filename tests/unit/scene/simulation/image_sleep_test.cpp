// An image that is left as it was is the one that would have been made.
#include "acus/scene/simulation/image_sleep.h"

#include <gtest/gtest.h>

#include "acus/base/core/random.h"
#include "support/effects_patient.h"
#include "support/effects_run.h"

namespace acus::simulation {
namespace {

using nlohmann::json;

/// A moment drawn from few: the same one often comes twice.
Snapshot Drawn(RandomStream& random) {
  const auto one_of = [&random](int count) { return static_cast<int>(random.Next() % count); };
  Snapshot s{.session_s = one_of(4) == 0 ? 0.25 : 0.0};
  s.probe_valid = one_of(8) != 0;
  s.ct_from_probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  s.ct_from_probe.translation() << 0.0, one_of(4) == 0 ? 3.0 : 0.0, 0.5;
  if (one_of(6) != 0) {
    // In the plane, near it, and far on one side.
    const double y_mm[] = {0.0, 4.5, 24.0, 25.0, 26.0};
    s.ct_from_needle = Eigen::Translation3d(0.0, y_mm[one_of(5)], 20.0) *
                       Eigen::AngleAxisd(1e-3 * one_of(2), Eigen::Vector3d::UnitX());
  }
  return s;
}

struct Counts {
  std::int64_t runs = 0;
  std::int64_t still = 0;
  std::int64_t off_plane = 0;
};
Counts CountsOf(const StageTimes::Cost& cost) {
  return {cost.runs, cost.asleep_for[static_cast<std::size_t>(Sleep::kNothingMoved)],
          cost.asleep_for[static_cast<std::size_t>(Sleep::kNeedleOffPlane)]};
}

TEST(ImageSleep, WhatSleepsWouldHaveGivenTheSameBits) {
  const testing_support::EffectsPatient patient;
  for (const char* model : {"columns_2010", "vidal_2008", "alamilla_2021", "beams", "aperture"}) {
    SCOPED_TRACE(model);
    const auto s = patient.With({{"ultrasound", {{"model", model}}},
                                 {"ct_slice", json::object()},
                                 {"fluoroscopy", json::object()},
                                 {"breathing", {{"motion", "sinusoid"}}}});
    RunContext context;
    const Scene scene =
        LoadScene(s, PlanEffects(s, {.needle_poses = true, .probe_poses = true}), context);
    ProbeImageRenderer renderer(scene);
    EffectImageRenderer c_arm(scene, scene.listed.all().front(), context);
    RandomStream random(7, model);
    ProbeImages kept, anew;
    effects::EffectPixels shadow, shadow_anew;
    StageTimes times(scene.plan);
    Snapshot before = Drawn(random);
    renderer.Render(before, kept);
    c_arm.Render(before, nullptr, shadow);
    constexpr int kMoments = 80;
    for (int i = 0; i < kMoments; ++i) {
      const Snapshot now = Drawn(random);
      renderer.Render(now, kept, &times, &before);
      renderer.Render(now, anew);
      ASSERT_EQ(kept.b_mode.pixels, anew.b_mode.pixels) << i;
      ASSERT_EQ(kept.ct_slice.pixels, anew.ct_slice.pixels) << i;
      if (i % 4 == 0) {
        c_arm.Render(now, nullptr, shadow, &times, &before);
        c_arm.Render(now, nullptr, shadow_anew);
        ASSERT_EQ(shadow.gray.pixels, shadow_anew.gray.pixels) << i;
      } else {
        c_arm.Render(now, nullptr, shadow);
      }
      before = now;
    }
    for (const effects::PortRef id : std::initializer_list<effects::PortRef>{
             effects::ports::kBMode, effects::ports::kCtImage}) {
      const Counts counts = CountsOf(times.Of(scene.plan.WriterOf(id)));
      EXPECT_EQ(counts.runs, kMoments);
      EXPECT_GT(counts.still, 0);
      EXPECT_GT(counts.off_plane, 0);
      EXPECT_LT(times.Of(scene.plan.WriterOf(id)).asleep, kMoments - 10);
    }
  }
}

TEST(ImageSleep, OnlyTheNeedlesShadowIsNewWhileThePatientStays) {
  const testing_support::EffectsPatient patient;
  const auto s = patient.With({{"fluoroscopy", json::object()}});
  RunContext context;
  const Scene scene = LoadScene(s, PlanEffects(s, {.needle_poses = true}), context);
  const ListedEffect& fluoroscopy = scene.listed.all().front();
  EffectImageRenderer kept(scene, fluoroscopy, context);
  EffectImageRenderer anew(scene, fluoroscopy, context);
  effects::EffectPixels shadow, shadow_anew, first;
  Snapshot before;
  kept.Render(before, nullptr, first);
  shadow = first;
  StageTimes times(scene.plan);
  for (const double z_mm : {10.0, 20.0, 20.0, 35.0}) {
    Snapshot now;
    now.ct_from_needle = Eigen::Translation3d(1.0, 0.0, z_mm) * Eigen::Isometry3d::Identity();
    kept.Render(now, nullptr, shadow, &times, &before);
    anew.Render(now, nullptr, shadow_anew);
    EXPECT_EQ(shadow.gray.pixels, shadow_anew.gray.pixels) << z_mm;
    EXPECT_NE(shadow.gray.pixels, first.gray.pixels);
    before = now;
  }
  EXPECT_EQ(times.cost[fluoroscopy.image_stage].asleep, 1);
  // The needle is gone: so is its shadow.
  kept.Render({}, nullptr, shadow, &times, &before);
  EXPECT_EQ(shadow.gray.pixels, first.gray.pixels);
}

TEST(ImageSleep, LoadsAndShapesThatDifferInOneBitWakeIt) {
  const Scene scene = [] {
    Scene s = testing_support::LayeredScene(testing_support::PlanOf(true, true, false, true), true);
    s.tools_deform_images = true;
    return s;
  }();
  tissue::TissueLoad a;
  a.num_points = 2;
  a.point[1].force_in_ct_n << 0.0, 0.1, 0.0;
  tissue::TissueLoad b = a;
  Snapshot before{.load = &a};
  Snapshot now{.load = &b};
  EXPECT_TRUE(TissueHasStayed(scene, before, now));
  b.point[1].force_in_ct_n.x() = -0.0;
  EXPECT_FALSE(TissueHasStayed(scene, before, now));
  b = a;
  b.needle.friction_n = 1e-300;
  EXPECT_FALSE(TissueHasStayed(scene, before, now));
  now.load = nullptr;
  EXPECT_FALSE(TissueHasStayed(scene, before, now));
  math::Polyline straight;
  straight.Add({0, 0, 0});
  straight.Add({0, 0, 9});
  math::Polyline bent = straight;
  before.ct_from_needle = now.ct_from_needle = Eigen::Isometry3d::Identity();
  before.needle_shape = &straight;
  now.needle_shape = &bent;
  EXPECT_TRUE(NeedleHasStayed(before, now));
  bent.point_mm[1].x() = 1e-12;
  EXPECT_FALSE(NeedleHasStayed(before, now));
  // A place that is no number is neither before nor behind the plane.
  bent.point_mm[1].x() = std::nan("");
  now.ct_from_probe = Eigen::Translation3d(0, 0, 500) * Eigen::Isometry3d::Identity();
  EXPECT_FALSE(NeedleIsOffPlane(scene, now, 10.0));
}

TEST(Sleep, StepsSayWhyTheyHadNothingToDo) {
  const testing_support::EffectsPatient patient;
  const auto s = patient.With({{"needle_force", json::object()},
                               {"needle", {{"model", "bendable"}}},
                               {"probe_force", {{"model", "vidal"}}},
                               {"breathing", {{"motion", "sinusoid"}, {"amplitude", 0}}}});
  RunContext context;
  const Scene scene =
      LoadScene(s, PlanEffects(s, {.needle_poses = true, .probe_poses = true}), context);
  testing_support::EffectsRun run(scene);
  StageTimes times(scene.plan);
  run.Steps(30, {.needle_in = false, .probe_on = false}, nullptr, &times);
  const auto asleep = [&](effects::PortRef id, Sleep why) {
    return times.Of(scene.plan.WriterOf(id)).asleep_for[static_cast<std::size_t>(why)];
  };
  EXPECT_EQ(asleep(effects::ports::kBreath, Sleep::kAtRest), 30);
  EXPECT_EQ(asleep(effects::ports::kForce, Sleep::kNeedleOutside), 30);
  EXPECT_EQ(asleep(effects::ports::kShape, Sleep::kNeedleOutside), 30);
  EXPECT_EQ(asleep(effects::ports::kProbeForce, Sleep::kProbeOffSkin), 30);
  run.Steps(330, {}, nullptr, &times);
  EXPECT_LT(times.Of(scene.plan.WriterOf(effects::ports::kForce)).asleep, 120);
  EXPECT_EQ(times.Of(scene.plan.WriterOf(effects::ports::kProbeForce)).asleep, 30);
  EXPECT_EQ(times.Of(scene.plan.WriterOf(effects::ports::kForce)).runs, 330);
  EXPECT_GT(times.Of(scene.plan.WriterOf(effects::ports::kForce)).seconds, 0.0);
  Simulation simulation(scene);
  State state = simulation.NewState();
  StageTimes unseen(scene.plan);
  simulation.Step(state, {.time_ns = 1}, &unseen);
  for (const effects::PortRef id : std::initializer_list<effects::PortRef>{
           effects::ports::kNeedle, effects::ports::kTissue, effects::ports::kForce}) {
    EXPECT_EQ(unseen.Of(scene.plan.WriterOf(id))
                  .asleep_for[static_cast<std::size_t>(Sleep::kNeedleUnseen)],
              1);
  }
}

}  // namespace
}  // namespace acus::simulation
