#include "simulation/effect_plan.h"

#include <gmock/gmock.h>

#include "core/error.h"

namespace acus::simulation {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

scenario::Scenario AllEffects() {
  scenario::Scenario s;
  s.file = "scene.json";
  s.patient.ct = "ct.nrrd";
  s.patient.labels = "labels.seg.nrrd";
  s.needle_force.emplace();
  s.ultrasound.emplace();
  s.ct_slice.emplace();
  return s;
}

constexpr AvailableInputs kAll{.needle_poses = true, .probe_poses = true};

std::vector<std::string_view> StagesIn(const EffectPlan& plan) {
  std::vector<std::string_view> names;
  for (const PlannedStage& stage : plan.stages()) {
    if (stage.in) names.push_back(stage.name);
  }
  return names;
}

TEST(PlanEffects, RunsProducersBeforeConsumers) {
  const EffectPlan plan = PlanEffects(AllEffects(), kAll);
  EXPECT_THAT(StagesIn(plan), testing::ElementsAre("needle pose", "tissue lookup", "needle force",
                                                   "probe pose", "CT slice", "B-mode"));
  EXPECT_TRUE(plan.Needs("ct"));
  EXPECT_TRUE(plan.Needs("labels"));
}

TEST(PlanEffects, LeavesOutWhatNoEffectNeeds) {
  scenario::Scenario forces_only = AllEffects();
  forces_only.ultrasound.reset();
  forces_only.ct_slice.reset();
  forces_only.patient.ct.clear();  // Not needed, so it need not exist.
  const EffectPlan plan = PlanEffects(forces_only, {.needle_poses = true});
  EXPECT_THAT(StagesIn(plan), testing::ElementsAre("needle pose", "tissue lookup", "needle force"));
  EXPECT_FALSE(plan.Needs("ct"));

  scenario::Scenario images_only = AllEffects();
  images_only.needle_force.reset();
  images_only.ultrasound->needle = false;
  images_only.ct_slice.reset();
  images_only.patient.labels.clear();
  EXPECT_THAT(StagesIn(PlanEffects(images_only, {.probe_poses = true})),
              testing::ElementsAre("probe pose", "B-mode"));
}

TEST(PlanEffects, KeepsTheNeedlePoseForAnImageThatShowsTheNeedle) {
  scenario::Scenario images = AllEffects();
  images.needle_force.reset();
  images.ct_slice.reset();
  const EffectPlan plan = PlanEffects(images, kAll);
  EXPECT_THAT(StagesIn(plan), testing::ElementsAre("needle pose", "probe pose", "B-mode"));
  EXPECT_EQ(plan.stages().front().reason, "needed by B-mode");
}

TEST(PlanEffects, NamesEveryMissingInputAtOnce) {
  scenario::Scenario s = AllEffects();
  s.patient.labels.clear();
  EXPECT_THAT([&] { PlanEffects(s, {.needle_poses = false, .probe_poses = true}); },
              ThrowsMessage<InputError>(AllOf(
                  HasSubstr("tissue lookup (needed by needle force) needs labels"),
                  HasSubstr("the session has no needle stream"), HasSubstr("--set /effects/"))));
}

}  // namespace
}  // namespace acus::simulation
