#include "acus/physics/tissue/spring_model.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numbers>

#include "acus/base/core/error.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;
using forces::NeedleEvent;
using testing_support::Layers;
using testing_support::ModelInsertion;

SpringModel SpringModelModel(const Layers& layers, const SpringSettings& settings = {}) {
  return SpringModel(settings, testing_support::RoundForces(), testing_support::Trocar18(),
                     testing_support::RoundElasticity(), layers.Tissues(), layers.At());
}

// By hand: a1 = 0.5 N/mm, a2 = 0.25 N/mm^2, f_cut = 3 N: 0.25 x^2 + 0.5 x = 3 at x = sqrt(13) - 1.
TEST(TipAdvance, IsEquation4AndItsUpdate) {
  const double held_mm = std::sqrt(13.0) - 1.0;
  EXPECT_EQ(TipAdvanceMm(-0.7, 0.5, 0.25, 3.0), -0.7);
  EXPECT_EQ(TipAdvanceMm(2.6, 0.5, 0.25, 3.0), 0.0);
  EXPECT_NEAR(TipAdvanceMm(4.0, 0.5, 0.25, 3.0), 4.0 - held_mm, 1e-15);
  EXPECT_NEAR(TipAdvanceMm(held_mm + 1e-9, 0.5, 0.25, 3.0), 1e-9, 1e-14);
  // Linear: 2 N/mm and 1 N leave half a millimetre.
  EXPECT_EQ(TipAdvanceMm(0.49, 2.0, 0.0, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(TipAdvanceMm(3.0, 2.0, 0.0, 1.0), 2.5);
  EXPECT_EQ(TipAdvanceMm(3.0, 0.0, 0.0, 1.0), 0.0);  // Nothing that could cut.
}

// By hand: k = 0.2 N/mm, R = 0.1 N: at most 0.5 mm either way.
TEST(FrictionOffset, IsEquation6) {
  EXPECT_DOUBLE_EQ(FrictionOffsetMm(0.1, 0.3, 0.2, 0.1), 0.4);
  EXPECT_DOUBLE_EQ(FrictionOffsetMm(0.4, 0.3, 0.2, 0.1), 0.5);
  EXPECT_DOUBLE_EQ(FrictionOffsetMm(0.5, -0.3, 0.2, 0.1), 0.2);
  EXPECT_DOUBLE_EQ(FrictionOffsetMm(0.5, -30.0, 0.2, 0.1), -0.5);
  EXPECT_EQ(FrictionOffsetMm(0.5, 1.0, 0.0, 0.1), 0.0);
}

TEST(SpringModel, StiffnessIsThatOfARodInACylinderOfTissue) {
  const SpringModel model = SpringModelModel({{{0, "fat"}}});
  const double g = 0.01 / (2 * 1.49);
  const double log_ratio = std::log(20.0 / 0.635);
  const PathNode& fat = model.TissueNode(volume::LabelOf("fat"));
  EXPECT_NEAR(fat.axial_n_per_mm, 2.0 * 2 * std::numbers::pi * g / log_ratio, 1e-12);
  EXPECT_NEAR(fat.lateral_n_per_mm, 2.0 * 4 * std::numbers::pi * g / (log_ratio - 0.997986), 1e-6);
  EXPECT_DOUBLE_EQ(fat.friction_n, 2.0 * 0.01);
}

// Fortmeier-2016, section 4.1: k = 0.5 N/mm for each node, one constant along the needle and across
// it.
TEST(SpringModel, BothSpringsOfFortmeier2016AreAsPrinted) {
  const std::filesystem::path configs = std::filesystem::path(ACUS_SOURCE_DIR) / "configs";
  const auto needle = needle::ReadNeedle(configs / "needles/measured_16g.json");
  const auto elasticity = mechanics::ReadElasticityTable(configs / "elasticity/fortmeier.json");
  const Layers layers{{{0, "skin"}, {2, "fat"}, {20, "liver"}}};
  for (const char* name : {"forces/fortmeier.json", "forces/fortmeier_bovine.json"}) {
    const SpringModel model({.node_spacing_mm = 2.0}, forces::ReadForceTable(configs / name),
                            needle, elasticity, layers.Tissues(), layers.At());
    for (const char* tissue : {"skin", "fat", "liver"}) {
      const PathNode& node = model.TissueNode(volume::LabelOf(tissue));
      EXPECT_NEAR(node.axial_n_per_mm, 0.5, 0.005) << name << ", " << tissue;
      EXPECT_NEAR(node.lateral_n_per_mm, 0.5, 0.005) << name << ", " << tissue;
      EXPECT_NEAR(node.friction_n, 0.025, 1e-12) << name << ", " << tissue;
    }
  }
}

// Skin 2 mm of 0.03 N/mm, fat 0.01 N/mm; after enough travel all springs slide.
TEST(SpringModel, PlateauIsCuttingPlusFrictionOfTheBuriedShaft) {
  const SpringModel model = SpringModelModel({{{0, "skin"}, {2, "fat"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(60.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.4, 1e-9);
  EXPECT_EQ(insertion.last.puncture_n, 0.0);
  const double tip_mm = 60.0 - 0.4 / model.table().settings.cutting_stiffness_n_per_mm;
  // Nodes stand for the segment in front of them: one spacing may be in the wrong layer.
  EXPECT_NEAR(insertion.last.friction_n, 0.03 * 2 + 0.01 * (tip_mm - 2), 0.06);
  EXPECT_NEAR(insertion.last.depth_mm, 60.0, 1e-3);
  EXPECT_EQ(insertion.last.lateral_n, 0.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kContact), 1);
  EXPECT_EQ(insertion.Count(NeedleEvent::kPuncture), 1);
  EXPECT_EQ(insertion.state.node[insertion.state.num_nodes - 1].tissue, volume::LabelOf("fat"));
}

TEST(SpringModel, SkinIsPressedByItsPolynomialUntilPuncture) {
  const SpringModel model = SpringModelModel({{{0, "skin"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(4.0);
  EXPECT_NEAR(insertion.last.puncture_n, 0.1 * 4 + 0.05 * 16, 1e-6);
  EXPECT_EQ(insertion.state.num_nodes, 1);
  double peak_n = 0.0;
  while (insertion.Count(NeedleEvent::kPuncture) == 0) {
    peak_n = insertion.last.AxialN();
    insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, 0.005));
  }
  EXPECT_NEAR(peak_n, 2.1, 0.01);
  EXPECT_NEAR(insertion.last.cutting_n, 1.0, 1e-9);
  EXPECT_GE(insertion.state.num_nodes, 2);
}

TEST(SpringModel, CapsuleAddsItsPolynomialWithoutAStep) {
  const SpringModel model = SpringModelModel({{{0, "fat"}, {20, "liver"}}});
  ModelInsertion<SpringModel> insertion{model};
  double largest_step_n = 0.0;
  double before_n = 0.0;
  while (insertion.Count(NeedleEvent::kPuncture) == 0 && insertion.tip_mm.z() < 60) {
    before_n = insertion.last.AxialN();
    insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, 0.01));
    const double step_n = insertion.last.AxialN() - before_n;
    if (insertion.tip_mm.z() > 1.0) largest_step_n = std::max(largest_step_n, step_n);
  }
  EXPECT_EQ(insertion.Count(NeedleEvent::kPuncture), 1);
  EXPECT_LT(largest_step_n, 0.005);
  const double capsule_mm =
      model.table().tissue[volume::LabelOf("liver")].membrane.PunctureDepthMm();
  EXPECT_NEAR(insertion.tip_mm.z(), 20.0 + capsule_mm, 0.02);
  insertion.MoveToDepth(50.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.8, 1e-9);
}

TEST(SpringModel, BoneStopsThePathAndPushesBack) {
  const SpringModel model = SpringModelModel({{{0, "fat"}, {20, "bone"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(20.9);
  EXPECT_EQ(insertion.Count(NeedleEvent::kBoneContact), 1);
  const auto& tip = insertion.state.node[insertion.state.num_nodes - 1];
  EXPECT_NEAR(tip.rest_in_ct_mm.z(), 20.0, 1e-6);
  const double pressed_mm = 0.4 / model.table().settings.cutting_stiffness_n_per_mm;
  EXPECT_NEAR(insertion.last.bone_penetration_mm, 0.9 - pressed_mm, 1e-3);
  insertion.StepTo(insertion.tip_mm);  // At rest, without the damper.
  EXPECT_NEAR(insertion.last.bone_n,
              model.table().settings.bone.stiffness_n_per_mm * (0.9 - pressed_mm), 0.01);
  insertion.MoveToDepth(19.5);
  EXPECT_EQ(insertion.Count(NeedleEvent::kBoneRelease), 1);
  EXPECT_EQ(insertion.last.bone_n, 0.0);
}

// Loading and unloading differ by twice the friction; a closed loop costs work.
TEST(SpringModel, FrictionHasAHysteresis) {
  const SpringModel model = SpringModelModel({{{0, "fat"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(60.0);
  const double in_n = insertion.last.friction_n;
  EXPECT_GT(in_n, 0.5);
  insertion.MoveToDepth(30.0);
  insertion.MoveToDepth(29.0);
  const double out_n = insertion.last.friction_n;
  EXPECT_NEAR(out_n, -0.01 * 29.0, 1e-6);
  EXPECT_EQ(insertion.last.cutting_n, 0.0);
  const double work = insertion.work_n_mm;
  for (const double stroke_mm : {0.05, 0.5, 5.0}) {
    insertion.MoveToDepth(29.0 - stroke_mm);
    insertion.MoveToDepth(29.0);
    EXPECT_GT(insertion.work_n_mm, work - 1e-6) << stroke_mm;
  }
  insertion.MoveToDepth(-2.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kWithdrawal), 1);
  EXPECT_EQ(insertion.state.num_nodes, 0);
  EXPECT_EQ(insertion.last.AxialN(), 0.0);
}

TEST(SpringModel, NeedleAcrossItsPathIsPulledBack) {
  const SpringModel model = SpringModelModel({{{0, "fat"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(40.0);
  insertion.StepTo(insertion.tip_mm + Vector3d(0.2, 0, 0));
  const double per_mm = model.TissueNode(volume::LabelOf("fat")).lateral_n_per_mm / 2.0;
  const double path_mm = insertion.state.node[insertion.state.num_nodes - 1].rest_in_ct_mm.z();
  EXPECT_NEAR(insertion.last.force_in_ct_n.x(), -0.2 * per_mm * path_mm, 1e-6);
  EXPECT_NEAR(insertion.last.lateral_n, 0.2 * per_mm * path_mm, 1e-6);
  insertion.StepTo(insertion.tip_mm + Vector3d(500, 0, 0));
  EXPECT_LE(insertion.last.lateral_n, model.table().settings.lateral_limit_n + 1e-12);
}

TEST(SpringModel, FrictionChangesAtMostAtItsRate) {
  SpringSettings slow;
  slow.friction_rate_n_per_s = 10.0;
  const SpringModel model = SpringModelModel({{{0, "skin"}}}, slow);
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(60.0, 2000.0);
  double before_n = insertion.last.friction_n;
  for (int i = 0; i < 100; ++i) {
    insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, i % 2 == 0 ? -20.0 : 20.0));
    EXPECT_LE(std::abs(insertion.last.friction_n - before_n), 0.01 + 1e-12);
    before_n = insertion.last.friction_n;
  }
}

TEST(SpringField, IsTheTipsAtTheTipAndFadesOut) {
  const SpringModel model = SpringModelModel({{{0, "skin"}, {2, "fat"}}});
  ModelInsertion<SpringModel> insertion{model};
  SpringField field(model);
  TissueLoad load;
  insertion.MoveToDepth(3.0);  // Pressing on the skin.
  model.LoadOf(insertion.state, load);
  field.Update(load);
  EXPECT_NEAR(field.DisplacementMm(Vector3d(0, 0, 0)).z(), 3.0, 1e-6);
  EXPECT_NEAR(field.DisplacementMm(Vector3d(10, 0, 0)).z(), 1.5, 1e-6);
  EXPECT_EQ(field.DisplacementMm(Vector3d(20, 0, 0)).norm(), 0.0);
  EXPECT_EQ(load.needle.pre_puncture_n, insertion.last.puncture_n);
  insertion.MoveToDepth(40.0);
  model.LoadOf(insertion.state, load);
  field.Update(load);
  const SpringState& state = insertion.state;
  for (int i = 2; i + 2 < state.num_nodes; ++i) {
    const Vector3d moved = field.DisplacementMm(state.node[i].rest_in_ct_mm);
    EXPECT_NEAR(moved.z(), state.node[i].offset_mm, 1e-9) << i;
  }
  const Vector3d tip = state.node[state.num_nodes - 1].rest_in_ct_mm;
  EXPECT_NEAR((tip + field.DisplacementMm(tip)).z(), 40.0, 1e-9);
  Vector3d before = field.DisplacementMm(Vector3d(1, 2, -21));
  EXPECT_EQ(before.norm(), 0.0);
  for (double z = -20.99; z < 62; z += 0.01) {
    const Vector3d now = field.DisplacementMm(Vector3d(1, 2, z));
    ASSERT_LT((now - before).norm(), 0.03) << z;
    ASSERT_GT((now - before).z(), -0.0099) << "folds at " << z;
    before = now;
  }
  EXPECT_EQ(before.norm(), 0.0);
}

TEST(SpringModel, SaysWhatIsWrong) {
  const Layers fat{{{0, "fat"}}};
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    SpringSettings settings;
    settings.node_spacing_mm = bad;
    EXPECT_THROW(SpringModelModel(fat, settings), InputError);
    settings = {};
    settings.influence_radius_mm = bad;
    EXPECT_THROW(SpringModelModel(fat, settings), InputError);
    settings = {};
    settings.friction_rate_n_per_s = bad;
    EXPECT_THROW(SpringModelModel(fat, settings), InputError);
  }
  EXPECT_THROW(SpringModelModel({{{0, "kidney"}}}), InputError);  // No row in the elasticity table.
}

// By hand, eq. 4 to 7 with a1 = 0.5 N/mm, a2 = 0.25 N/mm^2, f_cut = 3 N, nodes 2 mm apart with
// k = 0.2 N/mm and R = 0.1 N (offsets to 0.5 mm): f_cut is reached sqrt(13) - 1 = 2.605551 mm
// ahead.
TEST(SpringModel, FollowsATraceOfAlgorithm1ByHand) {
  const auto table = forces::ForceTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-forces/1", "reference_diameter_mm": 1.27, "tissues": [
      {"tissue": "soft_tissue", "source": "test", "cutting_a1_n_per_mm": 0.5,
       "cutting_a2_n_per_mm2": 0.25, "cutting_n": 3.0, "shaft_n_per_mm2": 0.1,
       "friction_n_per_mm": 0.05}]})"),
                                                "by hand");
  const Layers layers{{{0, "fat"}}};
  const SpringModel model({.node_spacing_mm = 2.0}, table, testing_support::Trocar18(),
                          testing_support::RoundElasticity(), layers.Tissues(), layers.At());
  SpringState state = model.NewState();
  struct Row {
    double device_mm, tip_mm, cutting_n, friction_n;
  };
  const Row trace[] = {
      {-1.0, 0.0, 0.0, 0.0},
      {1.0, 0.0, 0.75, 0.0},            // 0.25 + 0.5: held.
      {2.0, 0.0, 2.0, 0.0},             // 1 + 1: held.
      {3.0, 0.394449, 3.0, 0.0197224},  // Cuts; 0.1 N on 0.1972 of a spacing.
      {4.0, 1.394449, 3.0, 0.0697224},  // Cuts on.
      {3.5, 1.394449, 2.161112, 0.0},   // 2.105551 ahead; the offset is back at 0.
      {1.0, 1.0, 0.0, -0.05},           // The tip goes back; friction pulls, half a spacing.
      {3.0, 1.0, 2.0, 0.05},            // 2 ahead: held again.
  };
  double time_s = 0.0;
  for (const Row& row : trace) {
    const auto force = model.Step(
        state, {.time_s = time_s += 0.001, .tip_in_ct_mm = Vector3d(0, 0, row.device_mm)});
    const double tip_mm =
        state.num_nodes > 0 ? state.node[state.num_nodes - 1].rest_in_ct_mm.z() : 0.0;
    EXPECT_NEAR(tip_mm, row.tip_mm, 2e-6) << row.device_mm;
    EXPECT_NEAR(force.cutting_n, row.cutting_n, 5e-6) << row.device_mm;
    EXPECT_NEAR(force.friction_n, row.friction_n, 2e-6) << row.device_mm;
  }
}

// Bone behind tissue that is pressed in by a2, too: what cut it is not pressed against the bone.
TEST(SpringModel, BoneBehindANonLinearCutBeginsWithoutAStep) {
  const auto table = forces::ForceTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-forces/1", "reference_diameter_mm": 1.27, "tissues": [
      {"tissue": "soft_tissue", "source": "test", "cutting_a1_n_per_mm": 0.05,
       "cutting_a2_n_per_mm2": 0.02, "cutting_n": 1.0},
      {"tissue": "bone", "source": "test", "impenetrable": true}]})"),
                                                "bone");
  const Layers layers{{{0, "fat"}, {20, "bone"}}};
  const SpringModel model({}, table, testing_support::Trocar18(),
                          testing_support::RoundElasticity(), layers.Tissues(), layers.At());
  SpringState state = model.NewState();
  double before_n = 0.0;
  double largest_step_n = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const auto force =
        model.Step(state, {.time_s = 0.001 * n, .tip_in_ct_mm = Vector3d(0, 0, -1.0 + 0.01 * n)});
    largest_step_n = std::max(largest_step_n, std::abs(force.AxialN() - before_n));
    before_n = force.AxialN();
  }
  EXPECT_TRUE(state.on_bone);
  EXPECT_GT(before_n, 5.0);
  EXPECT_LT(largest_step_n, 0.2);
}

}  // namespace
}  // namespace acus::tissue
