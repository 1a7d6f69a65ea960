#include "acus/patient/phantom/planning/window_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/patient/phantom/planning/rib_shadow.h"
#include "acus/patient/phantom/planning/scene_plan.h"
#include "support/temporary_folder.h"
#include "unit/patient/phantom/window_patient.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

WindowPlan Requested(const std::string& target, const std::string& window) {
  const WindowPatient& patient = WindowPatient::Get();
  return PlanAsRequested(patient.labels, patient.field, patient.frame,
                         {.target = target, .window = window}, Preset("scene_target").insertion,
                         {});
}

/// What holds for every window: free, inside the limits, in plane, the probe on skin.
void ExpectSoundPlan(const WindowPlan& plan, const char* structure) {
  const PatientField& field = WindowPatient::Get().field;
  const InsertionPlan& insertion = plan.insertion;
  EXPECT_EQ(field.LabelAt(insertion.target_ct_mm), volume::LabelOf(structure));
  EXPECT_NEAR(field.SkinDistanceMm(insertion.entry_ct_mm), 0.0, 1e-3);
  EXPECT_NEAR(insertion.lateral().dot(insertion.direction), 0.0, 1e-9);
  EXPECT_GT(insertion.heading.dot(insertion.direction), 0.09);
  EXPECT_TRUE(ProbeUnevennessMm(field, insertion).has_value());
  PlanSettings strict;
  for (const char* name : {"bone", "lung", "gas"}) strict.avoid.push_back(volume::LabelOf(name));
  EXPECT_TRUE(PathIsFree(field, insertion.entry_ct_mm, insertion.target_ct_mm, strict));
}

double OffMidlineMm(const WindowPlan& plan) {
  const Vector3d& entry = plan.insertion.entry_ct_mm;
  return std::abs(entry.x() - WindowPatient::Get().frame.MiddleXMm(entry.z()));
}

TEST(WindowPlan, ParamedianIsBesideTheMidlineInASagittalObliqueImage) {
  const WindowPlan plan = Requested("", "paramedian");
  ExpectSoundPlan(plan, "spinal_canal");
  EXPECT_GE(OffMidlineMm(plan), 10.0);
  EXPECT_LE(OffMidlineMm(plan), 15.0);
  EXPECT_GT(std::abs(plan.insertion.heading.z()), 0.9);
  EXPECT_LT(std::abs(plan.insertion.lateral().z()), 0.1);
  EXPECT_TRUE(plan.insertion.bone_angle_rad.has_value());
}

TEST(WindowPlan, ReachesTheCanalBetweenTwoVertebrae) {
  const WindowPatient& patient = WindowPatient::Get();
  const Anatomy anatomy(Preset("liver").body, 1);
  // The bodies lie between the discs.
  const Vector3d upper = anatomy.Landmark("disc_L2L3");
  const Vector3d middle = anatomy.Landmark("disc_L3L4");
  const Vector3d lower = anatomy.Landmark("disc_L4L5");
  const testing_support::TemporaryFolder folder;
  std::string rows = "name,whole,x_mm,y_mm,z_mm,volume_ml\n";
  const auto add = [&](const char* name, const Vector3d& at) {
    rows += Message(name, ",1,", at.x(), ",", at.y(), ",", at.z(), ",40\n");
  };
  add("L3", 0.5 * (upper + middle));
  add("L4", 0.5 * (middle + lower));
  add("L5", lower + 0.5 * (lower - middle));
  WriteTextFile(folder / "vertebrae.csv", rows);
  for (const auto& [level, canal] :
       {std::pair("L3-L4", "canal_L3L4"), std::pair("L4-L5", "canal_L4L5")}) {
    const WindowPlan plan =
        PlanAsRequested(patient.labels, patient.field, patient.frame,
                        {.target = level, .window = "", .vertebrae = folder / "vertebrae.csv"},
                        Preset("scene_target").insertion, {});
    ExpectSoundPlan(plan, "spinal_canal");
    EXPECT_NEAR(plan.insertion.target_ct_mm.z(), anatomy.Landmark(canal).z(), 12.0) << level;
  }
}

TEST(WindowPlan, MidlineIsOnTheMidline) {
  const WindowPlan plan = Requested("spinal_canal", "midline");
  ExpectSoundPlan(plan, "spinal_canal");
  EXPECT_LE(OffMidlineMm(plan), 4.0);
  EXPECT_GT(std::abs(plan.insertion.lateral().x()), 0.95);
}

TEST(WindowPlan, TransverseIsAcrossTheBack) {
  const WindowPlan plan = Requested("spinal_canal", "transverse");
  ExpectSoundPlan(plan, "spinal_canal");
  EXPECT_GE(OffMidlineMm(plan), 15.0);
  EXPECT_GT(std::abs(plan.insertion.heading.x()), 0.85);
}

TEST(WindowPlan, IntercostalIsBetweenTwoRibsAndParallelToThem) {
  const WindowPlan plan = Requested("", "intercostal");
  ExpectSoundPlan(plan, "liver");
  EXPECT_TRUE(plan.view.IsGood()) << ViewText(plan.view);
  const RibShadow shadow(WindowPatient::Get().field, plan.insertion.entry_ct_mm,
                         SkinNormal(WindowPatient::Get().field, plan.insertion.entry_ct_mm));
  EXPECT_TRUE(shadow.IsBetweenRibs());
  EXPECT_LT(std::abs(plan.insertion.lateral().dot(shadow.rib_direction())), 0.1);
  EXPECT_FALSE(plan.insertion.bone_angle_rad.has_value());
}

TEST(WindowPlan, SubcostalGoesToTheLiverFromTheFrontAndBelow) {
  const WindowPlan plan = Requested("liver", "subcostal");
  ExpectSoundPlan(plan, "liver");
  EXPECT_GT(plan.insertion.direction.z(), 0.2) << "towards the head";
  EXPECT_GT(plan.insertion.direction.y(), 0.2) << "towards the back";
}

TEST(WindowPlan, FlankGoesToTheKidneyOfTheSideFromTheBack) {
  for (const double side : {1.0, -1.0}) {
    const WindowPlan plan = Requested(side > 0.0 ? "kidney_left" : "kidney_right", "");
    EXPECT_EQ(plan.window->name, "flank");
    ExpectSoundPlan(plan, "kidney");
    EXPECT_GT(side * plan.insertion.entry_ct_mm.x(), 45.0);
    EXPECT_LT(plan.insertion.direction.y(), 0.0) << "from behind";
  }
}

TEST(WindowPlan, ShortestIsNotLongerThanTheUsualWindow) {
  const double shortest_mm = Requested("liver", "shortest").insertion.length_mm();
  EXPECT_LE(shortest_mm, Requested("liver", "").insertion.length_mm() + 1.0);
}

TEST(WindowPlan, TheProbeSeesTargetAndNeedle) {
  for (const char* target : {"kidney_left", "kidney_right", "spinal_canal"}) {
    const WindowPlan plan = Requested(target, "");
    EXPECT_TRUE(plan.view.IsGood()) << target << ": " << ViewText(plan.view);
  }
}

TEST(WindowPlan, SaysWhatIsInBetweenAndWhichWindowsAreFree) {
  EXPECT_THAT(
      [] { Requested("spinal_canal", "subcostal"); },
      ThrowsMessage<NoAnswerError>(AllOf(HasSubstr("through the window subcostal"),
                                         HasSubstr("% meet bone"), HasSubstr("paramedian"))));
  EXPECT_THAT([] { Requested("", "anterior"); },
              ThrowsMessage<InputError>(HasSubstr("needs --target")));
}

TEST(WindowPlan, SaysThatAWindowLeadsToWhatTheMapLacks) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  EXPECT_THAT(
      [&] {
        PlanAsRequested(labels, field, BodyFrame(labels), {.target = "", .window = "flank"},
                        Preset("scene_target").insertion, {});
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("kidney"), HasSubstr("lacks"))));
}

TEST(RibShadow, FindsTheDirectionOfTwoBars) {
  // Bars along (1, 0, 0.5), 24 mm apart, 8 mm below a flat skin at y = 0; the body is behind it.
  volume::Geometry g;
  g.size = {60, 30, 60};
  g.spacing_mm = Eigen::Array3d::Constant(2.0);
  g.origin_mm = {-59.0, -9.0, -59.0};
  volume::LabelMap labels(g, 0);
  const Vector3d along = Vector3d(1.0, 0.0, 0.5).normalized();
  const Vector3d across(-along.z(), 0.0, along.x());
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
        if (p.y() < 0.0) continue;
        const bool bar = std::abs(std::abs(p.dot(across)) - 12.0) < 4.0 && p.y() > 8.0;
        labels.At(i, j, k) = volume::LabelOf(bar && p.y() < 16.0 ? "bone" : "soft_tissue");
      }
    }
  }
  const LabelMapField field(labels);
  const RibShadow between(field, Vector3d::Zero(), -Vector3d::UnitY());
  EXPECT_TRUE(between.IsBetweenRibs());
  EXPECT_GT(std::abs(between.rib_direction().dot(along)), std::cos(0.12));
  EXPECT_FALSE(RibShadow(field, 12.0 * across, -Vector3d::UnitY()).IsBetweenRibs()) << "on one";
  EXPECT_FALSE(RibShadow(field, 24.0 * across, -Vector3d::UnitY()).IsBetweenRibs()) << "beyond";
}

TEST(ScenePlan, TakesASpinalCanalWhereThereIsNoLiver) {
  volume::LabelMap labels = WindowPatient::Get().labels;
  for (volume::Label& label : labels.voxels) {
    for (const char* organ : {"liver", "lesion", "kidney", "gallbladder"})
      if (label == volume::LabelOf(organ)) label = volume::LabelOf("soft_tissue");
  }
  const LabelMapField field(labels);
  const ScenePlan plan = PlanScene(labels, field, Preset("scene").insertion, {}, {});
  EXPECT_EQ(field.LabelAt(plan.insertion.target_ct_mm), volume::LabelOf("spinal_canal"));
  EXPECT_THAT(plan.choice.window, HasSubstr("paramedian"));
  EXPECT_THAT(plan.choice.reason, HasSubstr("not labelled: liver, kidney"));
  // Without names of vertebrae it may be anywhere in the spine.
  EXPECT_EQ(plan.choice.title, "Puncture of the spinal canal, at a level without a name");
  EXPECT_TRUE(plan.touches_bone);
}

/// The window patient without organs, and the levels of its spine with three names.
ScenePlan SpinalScene(const std::vector<std::string>& names, const std::string& target) {
  volume::LabelMap labels = WindowPatient::Get().labels;
  for (volume::Label& label : labels.voxels) {
    for (const char* organ : {"liver", "lesion", "kidney", "gallbladder"})
      if (label == volume::LabelOf(organ)) label = volume::LabelOf("soft_tissue");
  }
  const Anatomy anatomy(Preset("liver").body, 1);
  const Vector3d middle = anatomy.Landmark("disc_L3L4");
  const Vector3d step = 0.5 * (anatomy.Landmark("disc_L4L5") - anatomy.Landmark("disc_L2L3"));
  std::string rows = "name,whole,x_mm,y_mm,z_mm,volume_ml\n";
  for (std::size_t n = 0; n < names.size(); ++n) {
    const Vector3d at = middle + (static_cast<double>(n) - 1.5) * step;
    rows += Message(names[n], ",1,", at.x(), ",", at.y(), ",", at.z(), ",40\n");
  }
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder / "vertebrae.csv", rows);
  const LabelMapField field(labels);
  return PlanScene(labels, field, Preset("scene").insertion,
                   {.target = target, .window = "", .vertebrae = folder / "vertebrae.csv"}, {});
}

TEST(ScenePlan, IsALumbarPunctureOnlyAtANamedLumbarLevel) {
  for (const char* target : {"", "spinal_canal"}) {
    EXPECT_EQ(SpinalScene({"L2", "L3", "L4", "L5"}, target).choice.title,
              "Lumbar puncture at L3-L4");
    EXPECT_THAT(
        SpinalScene({"vertebra_1", "vertebra_2", "vertebra_3", "vertebra_4"}, target).choice.title,
        testing::StartsWith("Puncture of the spinal canal"));
  }
  // The same place, where its names are those of the chest.
  EXPECT_THAT(SpinalScene({"T10", "T11", "T12", "L1"}, "").choice.title,
              testing::StartsWith("Puncture of the spinal canal"));
}

TEST(ScenePlan, LooksForAKnownTargetWithTheSettingsOfARequestedOne) {
  const PlanSettings ours = SettingsForTarget(Preset("scene").insertion);
  const PlanSettings preset = Preset("scene_target").insertion;
  EXPECT_EQ(ours.min_length_mm, preset.min_length_mm);
  EXPECT_EQ(ours.max_length_mm, preset.max_length_mm);
  EXPECT_EQ(ours.clearance_mm, preset.clearance_mm);
  EXPECT_THAT(ours.avoid, testing::IsSupersetOf(preset.avoid));
}

TEST(ScenePlan, GoesIntoAShoulderOnlyIfTheTrunkHasNoPath) {
  // A trunk with lungs right under its fat beside a shoulder of soft tissue.
  volume::LabelMap labels = SyntheticBody();
  const volume::Geometry& g = labels.geometry;
  const auto fill = [&](double limit_mm) {
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
          const bool in_lung = std::abs(p.x()) < 60.0 && std::abs(p.y()) < limit_mm;
          if (in_lung && labels.At(i, j, k) != 0) labels.At(i, j, k) = volume::LabelOf("lung");
        }
      }
    }
  };
  fill(30.0);
  const auto target_of = [&] {
    const LabelMapField field(labels);
    return PlanScene(labels, field, Preset("scene").insertion, {}, {});
  };
  EXPECT_LT(std::abs(target_of().insertion.target_ct_mm.x()), 62.0);
  fill(120.0);
  const ScenePlan beside = target_of();
  EXPECT_GT(std::abs(beside.insertion.target_ct_mm.x()), 60.0);
  EXPECT_THAT(beside.choice.reason, HasSubstr("no path in the trunk is free"));
}

}  // namespace
}  // namespace acus::phantom
