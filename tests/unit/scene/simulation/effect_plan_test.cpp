#include "acus/scene/simulation/effect_plan.h"

#include <algorithm>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/scene/effects/view_3d/view_3d.h"

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
  EXPECT_TRUE(plan.Needs(effects::ports::kCt));
  EXPECT_TRUE(plan.Needs(effects::ports::kLabels));
}

TEST(PlanEffects, EachModelOfTheUltrasoundReadsItsOwnVolume) {
  scenario::Scenario s = AllEffects();
  s.needle_force.reset();
  s.ct_slice.reset();
  s.ultrasound->model = scenario::UltrasoundModel::kVidal2008;
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kLabels));
  s.ultrasound->model = scenario::UltrasoundModel::kAlamilla2021;
  s.patient.ct.clear();
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kLabels));
}

TEST(PlanEffects, LeavesOutWhatNoEffectNeeds) {
  scenario::Scenario forces_only = AllEffects();
  forces_only.ultrasound.reset();
  forces_only.ct_slice.reset();
  forces_only.patient.ct.clear();  // Not needed, so it need not exist.
  const EffectPlan plan = PlanEffects(forces_only, {.needle_poses = true});
  EXPECT_THAT(StagesIn(plan), testing::ElementsAre("needle pose", "tissue lookup", "needle force"));
  EXPECT_FALSE(plan.Needs(effects::ports::kCt));

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
  EXPECT_EQ(plan.WriterOf(effects::ports::kNeedle).reason, "needed by B-mode");
}

TEST(PlanEffects, TheNeedlesShapeComesBetweenItsForceAndTheImages) {
  scenario::Scenario s = AllEffects();
  s.shape.emplace().model = scenario::NeedleModelKind::kBendable;
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_THAT(StagesIn(plan),
              testing::ElementsAre("needle pose", "tissue lookup", "needle force", "needle shape",
                                   "probe pose", "CT slice", "B-mode"));
  EXPECT_TRUE(plan.Needs(effects::ports::kShape));
  EXPECT_TRUE(plan.Needs(effects::ports::kNeedleElasticity));
  s.shape->model = scenario::NeedleModelKind::kRigid;
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kNeedleElasticity));
  EXPECT_FALSE(PlanEffects(AllEffects(), kAll).Writes(effects::ports::kShape));
}

TEST(PlanEffects, TheViewReadsWhatItShowsAndNothingElse) {
  scenario::Scenario s;
  s.file = "scene.json";
  s.patient.labels = "labels.seg.nrrd";
  nlohmann::json settings = {{"projection", "emission"},
                             {"layers", nlohmann::json::array()},
                             {"surfaces", {{{"tissue", "liver"}}}},
                             {"needle", true},
                             {"probe", false},
                             {"pressed", true},
                             {"picture", true},
                             {"force_arrow_mm_per_n", 0.0}};
  s.listed.push_back({&effects::View3d(), settings});
  const EffectPlan plan = PlanEffects(s, {.needle_poses = true});
  EXPECT_THAT(StagesIn(plan), testing::ElementsAre("needle pose", "view in 3D"));
  EXPECT_FALSE(plan.Needs(effects::ports::kCt));
  // The image in the probe's plane is that of the ultrasound.
  s.patient.ct = "ct.nrrd";
  s.listed.front().settings["probe"] = true;
  s.ultrasound.emplace();
  EXPECT_THAT(StagesIn(PlanEffects(s, kAll)),
              testing::ElementsAre("needle pose", "probe pose", "B-mode", "view in 3D"));
  s.ultrasound.reset();
  s.listed.front().settings["projection"] = "maximum";
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
}

TEST(PlanEffects, NamesEveryMissingInputAtOnce) {
  scenario::Scenario s = AllEffects();
  s.patient.labels.clear();
  s.patient.ct.clear();
  EXPECT_THAT([&] { PlanEffects(s, {.needle_poses = false, .probe_poses = true}); },
              ThrowsMessage<InputError>(AllOf(
                  HasSubstr("tissue lookup (needed by needle force) needs labels"),
                  HasSubstr("the session has no needle stream"), HasSubstr("--set /effects/"))));
}

TEST(PlanEffects, ForcesGoByTheCtWhereThereAreNoLabelsOrTheModelRequestsIt) {
  scenario::Scenario s = AllEffects();
  s.ultrasound.reset();
  s.ct_slice.reset();
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  s.needle_force->model = scenario::NeedleForceModelKind::kVidal;
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kLabels));
  s.needle_force->model = scenario::NeedleForceModelKind::kAlamilla;
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  s.patient.labels.clear();
  EXPECT_TRUE(PlanEffects(s, kAll).Needs(effects::ports::kCt));
  EXPECT_FALSE(PlanEffects(s, kAll).Needs(effects::ports::kLabels));
}

scenario::Scenario WithTissue(scenario::TissueModelKind model) {
  scenario::Scenario s = AllEffects();
  s.patient.mesh = "mesh/mesh.vtu";
  s.patient.corridor = "corridor.csv";
  s.tissue.emplace().model = model;
  return s;
}

TEST(PlanEffects, PutsDeformationBeforeTheImagesThatShowIt) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.needle_force->model = scenario::NeedleForceModelKind::kTissue;
  s.patient.labels.clear();  // The mesh knows its tissues.
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_THAT(StagesIn(plan),
              testing::ElementsAre("needle pose", "tissue contact", "needle force", "probe pose",
                                   "deformation", "CT slice", "B-mode"));
  EXPECT_TRUE(plan.Needs(effects::ports::kMesh));
  EXPECT_FALSE(plan.Needs(effects::ports::kLabels));
  EXPECT_FALSE(plan.Needs(effects::ports::kCorridor));
}

TEST(PlanEffects, DisplacementFunctionsFollowTheForcesAndAreOnlyForImages) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kDisplacementFunctions);
  EXPECT_THAT(StagesIn(PlanEffects(s, kAll)),
              testing::ElementsAre("needle pose", "tissue lookup", "needle force", "probe pose",
                                   "deformation", "CT slice", "B-mode"));
  s.tissue->image = false;
  EXPECT_FALSE(PlanEffects(s, kAll).Writes(effects::ports::kRestMap));
  s.tissue->image = true;
  s.ultrasound.reset();
  s.ct_slice.reset();
  EXPECT_FALSE(PlanEffects(s, kAll).Writes(effects::ports::kRestMap));
}

TEST(PlanEffects, SceneWithoutTissueNeedsNothingOfIt) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.tissue.reset();
  s.patient.mesh.clear();
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_FALSE(plan.Writes(effects::ports::kContact));
  EXPECT_FALSE(plan.Writes(effects::ports::kRestMap));
  EXPECT_FALSE(plan.Needs(effects::ports::kMesh));
  EXPECT_FALSE(plan.Needs(effects::ports::kTissueElasticity));
  EXPECT_FALSE(plan.Needs(effects::ports::kTissueForceTable));
}

TEST(PlanEffects, AProbeForceNeedsOnlyWhatItsModelReads) {
  scenario::Scenario s;
  s.file = "scene.json";
  s.patient.ct = "ct.nrrd";
  s.probe_force.emplace();
  const EffectPlan vidal = PlanEffects(s, {.probe_poses = true});  // No needle.
  EXPECT_THAT(StagesIn(vidal), testing::ElementsAre("probe force"));
  EXPECT_TRUE(vidal.Needs(effects::ports::kCt));
  EXPECT_FALSE(vidal.Needs(effects::ports::kLabels));
  EXPECT_FALSE(vidal.Needs(effects::ports::kProbePreset));
  s.probe_force->model = scenario::ProbeForceModelKind::kMultiProxy;
  EXPECT_TRUE(PlanEffects(s, {.probe_poses = true}).Needs(effects::ports::kProbePreset));
  s.probe_force->is_fingertip = true;
  EXPECT_FALSE(PlanEffects(s, {.probe_poses = true}).Needs(effects::ports::kProbePreset));
  s.probe_force->reads_labels = true;
  EXPECT_THAT([&] { PlanEffects(s, {.needle_poses = true}); },
              ThrowsMessage<InputError>(AllOf(
                  HasSubstr("probe force (effect probe_force is called for) needs probe poses"),
                  HasSubstr("/patient/labels is not given"))));
}

TEST(PlanEffects, AProbeThatPressesTissueNeedsNoImages) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.needle_force->model = scenario::NeedleForceModelKind::kTissue;
  s.ultrasound.reset();
  s.ct_slice.reset();
  s.tissue->probe_contact = true;
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_THAT(StagesIn(plan),
              testing::ElementsAre("needle pose", "tissue contact", "needle force"));
  EXPECT_TRUE(plan.Reads(effects::ports::kContact, effects::ports::kProbePreset));
}

TEST(PlanEffects, AProbeThatFeelsTheTissueReadsItsContactAndNothingElse) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.tissue->probe_contact = true;
  s.probe_force.emplace().model = scenario::ProbeForceModelKind::kTissue;
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_TRUE(plan.Writes(effects::ports::kProbeForce));
  EXPECT_TRUE(plan.Reads(effects::ports::kProbeForce, effects::ports::kContact));
  EXPECT_FALSE(plan.Reads(effects::ports::kProbeForce, effects::ports::kProbeForceTable));
}

TEST(PlanEffects, StagesKnowTheEffectsThatTheyWorkFor) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kSprings);
  s.breathing.emplace();
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_THAT(plan.WriterOf(effects::ports::kNeedle).effects,
              testing::UnorderedElementsAre("needle_force", "tissue", "ct_slice", "ultrasound"));
  EXPECT_THAT(plan.WriterOf(effects::ports::kProbe).effects,
              testing::UnorderedElementsAre("ct_slice", "ultrasound"));
  EXPECT_THAT(plan.WriterOf(effects::ports::kRestMap).effects,
              testing::UnorderedElementsAre("tissue", "breathing", "ct_slice", "ultrasound"));
  EXPECT_THAT(plan.WriterOf(effects::ports::kShape).effects, testing::IsEmpty());
}

TEST(PlanEffects, SaysSoWhereNothingIsThereForAnEffectToChange) {
  scenario::Scenario s = AllEffects();
  s.needle_force.reset();
  s.ultrasound.reset();
  s.ct_slice->needle = false;
  s.breathing.emplace().image = false;
  const EffectPlan plan = PlanEffects(s, kAll);
  EXPECT_FALSE(plan.Writes(effects::ports::kBreath));
  EXPECT_EQ(plan.WriterOf(effects::ports::kBreath).reason,
            "effect breathing is called for, but none that it changes");
  EXPECT_FALSE(plan.Needs(effects::ports::kMotion));
}

TEST(RequireFiles, NamesFilesThatStagesReadAndThatAreNotThere) {
  scenario::Scenario s = AllEffects();
  s.needle = s.probe = s.needle_force->table = s.ultrasound->acoustics = ACUS_SOURCE_DIR;
  s.patient.labels = ACUS_SOURCE_DIR;
  EXPECT_THAT([&] { RequireFiles(PlanEffects(s, kAll), s); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("CT slice (effect ct_slice is called for) needs ct: /patient/ct: "
                                  "ct.nrrd: no such file or folder"),
                        HasSubstr("for effects/ultrasound"), HasSubstr("--set /effects/"))));
  s.ultrasound.reset();
  s.ct_slice.reset();
  EXPECT_NO_THROW(RequireFiles(PlanEffects(s, kAll), s));
}

TEST(PlanEffects, NamesWhatTissueLacks) {
  scenario::Scenario s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.patient.mesh.clear();
  EXPECT_THAT([&] { PlanEffects(s, kAll); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("tissue contact (effect tissue"),
                                              HasSubstr("acus-mesh --condense"))));
  s = WithTissue(scenario::TissueModelKind::kPlane2010);
  s.patient.corridor.clear();
  EXPECT_THAT([&] { PlanEffects(s, kAll); },
              ThrowsMessage<InputError>(HasSubstr("/patient/corridor")));
  s = WithTissue(scenario::TissueModelKind::kFem3d);
  s.tissue->probe_contact = true;
  EXPECT_THAT([&] { PlanEffects(s, {.needle_poses = true}); },
              ThrowsMessage<InputError>(HasSubstr("tissue contact")));
}

TEST(EffectPlan, TheSessionSaysHowThePatientBreathesIfItRecordedIt) {
  scenario::Scenario s;
  s.file = "breathing.json";
  s.patient.labels = "labels";
  s.needle_force.emplace();
  s.breathing.emplace();
  AvailableInputs recorded = kAll;
  recorded.breath = true;
  EXPECT_FALSE(PlanEffects(s, kAll).breath_from_session());
  EXPECT_TRUE(PlanEffects(s, recorded).breath_from_session());
  s.breathing->from_session = scenario::SessionBreath::kNever;
  EXPECT_FALSE(PlanEffects(s, recorded).breath_from_session());
  s.breathing->from_session = scenario::SessionBreath::kAlways;
  EXPECT_TRUE(PlanEffects(s, recorded).breath_from_session());
  EXPECT_THAT([&] { PlanEffects(s, kAll); },
              ThrowsMessage<InputError>(HasSubstr("the session has no breathing stream")));
  s.breathing.reset();
  EXPECT_FALSE(PlanEffects(s, recorded).breath_from_session());
}

}  // namespace
}  // namespace acus::simulation
