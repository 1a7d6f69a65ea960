#include "acus/patient/phantom/planning/insertion_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

volume::Label Label(const char* name) {
  return volume::LabelOf(name);
}

/// Labels on a straight line, every 0.1 mm.
std::vector<volume::Label> InsertionPlanAlong(const PatientField& field, const Vector3d& from,
                                              const Vector3d& direction, double length) {
  std::vector<volume::Label> labels;
  for (double s = 0.0; s <= length; s += 0.1) labels.push_back(field.LabelAt(from + s * direction));
  return labels;
}

class Patients : public testing::TestWithParam<std::tuple<const char*, int>> {};
INSTANTIATE_TEST_SUITE_P(Plan, Patients,
                         testing::Combine(testing::Values("lumbar", "liver"),
                                          testing::Values(1, 2, 3, 4, 5, 77)));

TEST_P(Patients, HaveAPathToTheTargetThatKeepsClearOfBone) {
  const Case c(std::get<0>(GetParam()), std::get<1>(GetParam()));
  EXPECT_NEAR(c.field.SkinDistanceMm(c.plan.entry_ct_mm), 0.0, 1e-3);
  EXPECT_EQ(c.plan.target_ct_mm, c.target_ct_mm);
  for (const volume::Label label :
       InsertionPlanAlong(c.field, c.plan.entry_ct_mm, c.plan.direction, c.plan.length_mm())) {
    EXPECT_NE(label, Label("bone"));
    EXPECT_NE(label, Label("lung"));
    EXPECT_NE(label, Label("gas"));
  }
  const bool lumbar = c.config.insertion.target == "canal_L3L4";
  EXPECT_EQ(c.field.LabelAt(c.plan.target_ct_mm), Label(lumbar ? "spinal_canal" : "lesion"));
}

TEST_P(Patients, HaveBoneNearThePathThatAFirstAttemptTouches) {
  const Case c(std::get<0>(GetParam()), std::get<1>(GetParam()));
  ASSERT_TRUE(c.plan.bone_angle_rad.has_value());
  const Vector3d direction =
      Eigen::AngleAxisd(*c.plan.bone_angle_rad, c.plan.bone_axis) * c.plan.direction;
  const Vector3d before = c.plan.entry_ct_mm + (c.plan.bone_depth_mm - 0.1) * direction;
  const Vector3d after = c.plan.entry_ct_mm + (c.plan.bone_depth_mm + 0.1) * direction;
  EXPECT_NE(c.field.LabelAt(before), Label("bone"));
  EXPECT_EQ(c.field.LabelAt(after), Label("bone"));
  EXPECT_LT(c.plan.bone_depth_mm, c.plan.length_mm());
}

TEST_P(Patients, HaveAnImagePlaneThatHoldsTheNeedle) {
  const Case c(std::get<0>(GetParam()), std::get<1>(GetParam()));
  EXPECT_NEAR(c.plan.lateral().dot(c.plan.direction), 0.0, 1e-9);
  EXPECT_NEAR(c.plan.heading.dot(c.plan.skin_normal), 0.0, 1e-9);
  EXPECT_NEAR(c.plan.heading.norm(), 1.0, 1e-9);
  EXPECT_GT(c.plan.heading.dot(c.plan.direction), 0.0) << "the needle leans away from the probe";
}

TEST(PathIsFree, SeesWhatIsWithinTheClearance) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  PlanSettings settings;
  settings.avoid = {Label("bone")};
  // Straight from the front the bar of bone is in the way, from behind it is not.
  EXPECT_FALSE(PathIsFree(field, Vector3d(0, -105, 0), Vector3d(0, -40, 0), settings));
  EXPECT_TRUE(PathIsFree(field, Vector3d(0, 105, 0), Vector3d(0, 40, 0), settings));
  // Alongside the bar, 10 mm behind its back face.
  const Vector3d side(122, -50, 0), inside(40, -50, 0);
  settings.clearance_mm = 6.0;
  EXPECT_TRUE(PathIsFree(field, side, inside, settings));
  settings.clearance_mm = 14.0;
  EXPECT_FALSE(PathIsFree(field, side, inside, settings));
  // A path that leaves the body again is no path.
  EXPECT_FALSE(PathIsFree(field, Vector3d(0, 105, 0), Vector3d(0, 180, 0), settings));
}

TEST(PlanToTarget, SaysWhyThereIsNoAnswer) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  PlanSettings settings;
  settings.avoid = {Label("bone")};
  settings.approach = -Vector3d::UnitY();  // Through the bar.
  settings.cone_rad = 0.3;
  EXPECT_THAT([&] { PlanToTarget(field, Vector3d(0, -40, 0), settings, {}); },
              ThrowsMessage<NoAnswerError>(HasSubstr("cone_deg")));
  EXPECT_THAT([&] { PlanToTarget(field, Vector3d(0, -40, 900), settings, {}); },
              ThrowsMessage<InputError>(HasSubstr("outside the volume")));
  EXPECT_THAT([&] { PlanToTarget(field, Vector3d(150, 100, 0), settings, {}); },
              ThrowsMessage<InputError>(HasSubstr("outside the body")));
}

TEST(PlanToTarget, TakesThePathNearestToTheApproach) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  PlanSettings settings;
  settings.avoid = {Label("bone")};
  settings.approach = Vector3d::UnitY();
  const InsertionPlan plan = PlanToTarget(field, Vector3d(0, 40, 0), settings, {});
  EXPECT_NEAR((plan.direction + Vector3d::UnitY()).norm(), 0.0, 1e-9);
  EXPECT_NEAR(plan.entry_ct_mm.y(), 105.0, 3.0);  // Within the voxel of 4 mm.
}

TEST(PlanAnywhere, FindsAFreePathInABodyOfSoftTissue) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  const PhantomConfig scene = Preset("scene");
  const InsertionPlan plan = PlanAnywhere(field, scene.insertion, {});
  EXPECT_GE(plan.length_mm(), scene.insertion.min_length_mm - 1e-9);
  EXPECT_LE(plan.length_mm(), scene.insertion.max_length_mm + 1e-9);
  EXPECT_EQ(field.LabelAt(plan.target_ct_mm), Label("soft_tissue"));
  for (const volume::Label label :
       InsertionPlanAlong(field, plan.entry_ct_mm, plan.direction, plan.length_mm())) {
    EXPECT_NE(label, Label("bone"));
  }
}

TEST(PlanAnywhere, PrefersTheLiver) {
  volume::LabelMap labels = SyntheticBody();
  const volume::Geometry& g = labels.geometry;
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    const auto i = static_cast<int>(n % static_cast<std::size_t>(g.size[0]));
    if (i < g.size[0] / 3 && labels.voxels[n] == Label("soft_tissue"))
      labels.voxels[n] = Label("liver");
  }
  const LabelMapField field(labels);
  const InsertionPlan plan = PlanAnywhere(field, Preset("scene").insertion, {});
  EXPECT_EQ(field.LabelAt(plan.target_ct_mm), Label("liver"));
}

TEST(PlanAnywhere, TakesAShorterPathIntoASmallBodyThatLiesAnywhere) {
  // A forearm, far from the middle of the volume.
  volume::Geometry g;
  g.size = {120, 120, 60};
  g.spacing_mm = Eigen::Array3d::Constant(3.0);
  volume::LabelMap labels(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double r = std::hypot(3.0 * i - 80.0, 3.0 * j - 70.0);
        if (r < 45.0) labels.At(i, j, k) = Label(r < 8.0 ? "bone" : "soft_tissue");
      }
    }
  }
  const LabelMapField field(labels);
  EXPECT_NEAR(field.body_ct_mm().center().x(), 80.0, 3.0);
  const InsertionPlan plan = PlanAnywhere(field, Preset("scene").insertion, {});
  EXPECT_LT(plan.length_mm(), 50.0);
  EXPECT_GE(plan.length_mm(), 20.0 - 1e-9);
  EXPECT_EQ(field.LabelAt(plan.target_ct_mm), Label("soft_tissue"));
}

TEST(PlanAnywhere, SaysSoIfBoneIsEverywhere) {
  volume::LabelMap labels = SyntheticBody();
  for (volume::Label& label : labels.voxels) label = label == 0 ? label : Label("bone");
  const LabelMapField field(labels);
  EXPECT_THROW(PlanAnywhere(field, Preset("scene").insertion, {}), NoAnswerError);
  labels.voxels.assign(labels.voxels.size(), 0);  // Nobody there.
  EXPECT_THROW(PlanAnywhere(field, Preset("scene").insertion, {}), NoAnswerError);
}

}  // namespace
}  // namespace acus::phantom
