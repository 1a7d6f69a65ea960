#include "acus/physics/tissue/plane_model_2010.h"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using forces::NeedleEvent;
using testing_support::Layers;
using testing_support::ModelInsertion;
using Insertion = ModelInsertion<PlaneModel2010>;

const Layers kSkinAndFat{{{0, "skin"}, {2, "fat"}}};

PlaneModel2010 Model(const Layers& layers, const PlaneSettings& settings = {},
                     const PlanePlacement& placement = {}) {
  return PlaneModel2010(settings, placement, testing_support::RoundForces(),
                        testing_support::Trocar18(), testing_support::RoundElasticity(),
                        layers.At());
}

TEST(PlaneModel2010, IsARegularGridWithThePlannedPathOnItsNodes) {
  const PlaneModel2010 model = Model(kSkinAndFat);
  EXPECT_EQ(model.planes().grid().columns, 31);
  EXPECT_EQ(model.planes().grid().rows, 35);
  const double radius_mm = 0.635;
  EXPECT_NEAR(model.planes().thickness_mm(), std::numbers::pi * 45 / std::log(45 / radius_mm),
              1e-12);
  // 4 rows above the skin and the border are not free.
  EXPECT_EQ(model.planes().num_free_nodes(), 29 * 30);
  EXPECT_LT((model.planes().planned().ToCtMm(
                 model.planes().grid().PositionMm(model.planes().grid().Node(15, 4))))
                .norm(),
            1e-12);
  const Vector3d p(3, -4, 17);
  EXPECT_LT((model.planes().planned().ToCtMm(model.planes().planned().ToPlaneMm(p).head<2>()) -
             Vector3d(3, 0, 17))
                .norm(),
            1e-12);
  EXPECT_NEAR(std::abs(model.planes().planned().ToPlaneMm(p).z()), 4.0, 1e-12);
}

TEST(PlaneModel2010, SkinIsAnElasticSupportUntilPuncture) {
  const PlaneModel2010 model = Model(kSkinAndFat);
  Insertion insertion{model};
  insertion.MoveToDepth(2.0);
  const int dof = model.planes().dof_of_node()[model.planes().grid().Node(15, 4)];
  const double per_mm = 1.0 / model.planes().compliance()(dof + 1, dof + 1);
  EXPECT_NEAR(insertion.last.puncture_n, 2.0 * per_mm, 1e-6);
  EXPECT_EQ(insertion.state.num_nodes, 1);
  double peak_n = 0.0;
  while (insertion.Count(NeedleEvent::kPuncture) == 0 && insertion.tip_mm.z() < 50) {
    peak_n = insertion.last.AxialN();
    insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, 0.005));
  }
  EXPECT_NEAR(peak_n, 2.1, 0.005);
  EXPECT_NEAR(insertion.tip_mm.z(), 2.1 / per_mm, 0.01);
  EXPECT_LE(insertion.last.AxialN(), 1.0 + 0.1);
}

// All nodes slide: cutting and friction of the buried shaft, which is as long as the tissue says.
TEST(PlaneModel2010, PlateauIsCuttingPlusFrictionOfTheBuriedShaft) {
  const PlaneModel2010 model = Model(kSkinAndFat);
  Insertion insertion{model};
  insertion.MoveToDepth(60.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.4, 2e-3);
  EXPECT_EQ(insertion.last.puncture_n, 0.0);
  const double buried_mm = insertion.state.tip_rest_mm;
  EXPECT_LT(buried_mm, 60.0);
  EXPECT_GT(buried_mm, 57.0);
  // The first node, on the skin, stands for 1.5 mm.
  EXPECT_NEAR(insertion.last.friction_n, 0.03 * 1.5 + 0.01 * (buried_mm - 1.5), 2e-3);
  EXPECT_EQ(insertion.Count(NeedleEvent::kContact), 1);
  EXPECT_EQ(insertion.Count(NeedleEvent::kPuncture), 1);
  // A straight needle in symmetrical tissue; the alternating diagonals are not quite that.
  EXPECT_LT(insertion.last.lateral_n, 0.02);
  EXPECT_EQ(insertion.state.contact.num_unresolved(), 0);
}

TEST(PlaneModel2010, SumOfTheNodesIsTheForceOnTheNeedle) {
  const PlaneModel2010 model = Model({{{0, "fat"}, {20, "liver"}}});
  Insertion insertion{model};
  TissueLoad load;
  for (const double z : {5.0, 21.0, 40.0, 30.0}) {
    insertion.MoveToDepth(z);
    model.LoadOf(insertion.state, load);
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < load.num_points; ++i) sum += load.point[i].force_in_ct_n;
    EXPECT_LT((sum + insertion.last.force_in_ct_n).norm(), 1e-12) << z;
  }
}

TEST(PlaneModel2010, CapsuleIsPressedInAndPunctured) {
  const PlaneModel2010 model = Model({{{0, "fat"}, {20, "liver"}}});
  Insertion insertion{model};
  double peak_n = 0.0;
  double largest_step_n = 0.0;
  while (insertion.Count(NeedleEvent::kPuncture) == 0 && insertion.tip_mm.z() < 60) {
    const double before_n = insertion.last.AxialN();
    insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, 0.01));
    const double tip_n = insertion.last.cutting_n + insertion.last.puncture_n;
    if (insertion.Count(NeedleEvent::kPuncture) == 0) {
      peak_n = std::max(peak_n, tip_n);
      largest_step_n = std::max(largest_step_n, std::abs(insertion.last.AxialN() - before_n));
    }
  }
  EXPECT_NEAR(peak_n, 1.5, 0.02);
  EXPECT_LT(largest_step_n, 0.05);
  EXPECT_NEAR(insertion.state.channel_mm, 20.0, 2.0);
  EXPECT_GT(insertion.tip_mm.z(), 20.5);
  insertion.MoveToDepth(45.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.8, 5e-3);
}

// A hand that gives way a little while it presses on a capsule does not meet it again: only what is
// drawn back farther than the hysteresis of 0.2 mm does.
TEST(PlaneModel2010, ACapsuleIsMetAgainOnlyAfterItWasLeft) {
  const PlaneModel2010 model = Model({{{0, "fat"}, {20, "liver"}}});
  for (const double back_mm : {0.0, 1.0}) {
    Insertion insertion{model};
    const auto advance = [&](double mm) {
      insertion.StepTo(insertion.tip_mm + Vector3d(0, 0, mm));
    };
    insertion.MoveToDepth(18.0, 40.0);
    while (insertion.Count(NeedleEvent::kInterface) == 0 && insertion.tip_mm.z() < 40)
      advance(0.02);
    for (int n = 0; n < 15; ++n) advance(0.02);
    while (insertion.state.engaged && insertion.tip_mm.z() > 10) advance(-0.005);
    ASSERT_GT(insertion.state.tip_rest_mm, insertion.state.channel_mm - 0.1);
    for (double mm = 0.0; mm < back_mm; mm += 0.02) advance(-0.02);
    while (insertion.Count(NeedleEvent::kPuncture) < 2 && insertion.tip_mm.z() < 60) advance(0.02);
    EXPECT_EQ(insertion.Count(NeedleEvent::kInterface), back_mm > 0.0 ? 2 : 1) << back_mm;
  }
}

TEST(PlaneModel2010, BoneStopsTheNeedle) {
  const PlaneModel2010 model = Model({{{0, "fat"}, {30, "bone"}}});
  Insertion insertion{model};
  insertion.MoveToDepth(29.0);
  const double before_n = insertion.last.AxialN();
  insertion.MoveToDepth(31.0);
  insertion.StepTo(insertion.tip_mm);
  EXPECT_EQ(insertion.Count(NeedleEvent::kBoneContact), 1);
  EXPECT_NEAR(insertion.state.channel_mm, 30.0, 1e-6);
  EXPECT_GT(insertion.last.bone_penetration_mm, 0.3);
  EXPECT_NEAR(insertion.last.bone_n,
              model.table().settings.bone.stiffness_n_per_mm * insertion.last.bone_penetration_mm,
              1e-6);
  EXPECT_GT(insertion.last.AxialN(), before_n + 3.0);
  insertion.MoveToDepth(20.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kBoneRelease), 1);
  EXPECT_LT(insertion.last.AxialN(), 0.0);
}

TEST(PlaneModel2010, ShaftSticksThenSlipsAndCostsWork) {
  const PlaneModel2010 model = Model({{{0, "fat"}}});
  Insertion insertion{model};
  insertion.MoveToDepth(50.0);
  const double in_n = insertion.last.friction_n;
  insertion.MoveToDepth(30.0);
  const double out_n = insertion.last.friction_n;
  EXPECT_NEAR(out_n, -0.01 * insertion.state.tip_rest_mm, 2e-3);
  EXPECT_GT(in_n, 0.4);
  EXPECT_NEAR(insertion.last.cutting_n, 0.0, 1e-9);
  for (const double stroke_mm : {0.02, 0.2, 2.0, 10.0}) {
    insertion.MoveToDepth(30.0 - 0.5 * stroke_mm);
    const double work = insertion.work_n_mm;
    insertion.MoveToDepth(30.0 - stroke_mm);
    insertion.MoveToDepth(30.0 - 0.5 * stroke_mm);
    EXPECT_GT(insertion.work_n_mm, work - 1e-6) << stroke_mm;
  }
  // In its channel the needle meets friction only, until it is where it was.
  insertion.MoveToDepth(45.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.0, 1e-9);
  insertion.MoveToDepth(52.0);
  EXPECT_NEAR(insertion.last.cutting_n, 0.4, 2e-3);
  insertion.MoveToDepth(-1.0);
  EXPECT_EQ(insertion.Count(NeedleEvent::kWithdrawal), 1);
  EXPECT_EQ(insertion.last.force_in_ct_n.norm(), 0.0);
}

TEST(PlaneModel2010, FullAndRestrictedUpdateAgree) {
  PlaneSettings settings;
  settings.spacing_mm = 4.5;
  const Layers body{{{0, "skin"}, {2, "fat"}, {20, "liver"}}};
  const PlaneModel2010 restricted = Model(body, settings);
  settings.update = PlaneUpdate::kFull;
  const PlaneModel2010 full = Model(body, settings);
  Insertion a{restricted};
  Insertion b{full};
  for (const auto& [z, tilt] :
       {std::pair{45.0, 0.0}, {30.0, 0.1}, {48.0, -0.05}, {-1.0, 0.0}, {20.0, 0.3}}) {
    a.axis = b.axis = Vector3d(std::sin(tilt), 0, std::cos(tilt));
    const Vector3d end(0.5 + 10 * tilt, 0, z);
    const Vector3d begin = a.tip_mm;
    for (int i = 1; i <= 300; ++i) {
      const Vector3d p = begin + (end - begin) * i / 300.0;
      ASSERT_LT((a.StepTo(p).force_in_ct_n - b.StepTo(p).force_in_ct_n).norm(), 1e-9) << p;
    }
  }
  EXPECT_GT(a.state.contact.num_swaps(), 50);
}

// The whole scene turned and the plane with it: the same forces.
TEST(PlaneModel2010, TurnsWithTheScene) {
  const Eigen::Isometry3d turn =
      Eigen::Translation3d(30, -12, 7) * Eigen::AngleAxisd(0.8, Vector3d(1, 2, -0.5).normalized());
  const Layers body{{{0, "skin"}, {2, "fat"}, {20, "liver"}}};
  const TissueAt at = body.At();
  const PlaneModel2010 upright = Model(body);
  PlanePlacement placement;
  placement.entry_in_ct_mm = turn.translation();
  placement.axis_in_ct = turn.linear() * Vector3d(0, 0, 3);
  placement.across_in_ct = turn.linear() * Vector3d(2, 0, 1);
  const PlaneModel2010 turned(
      {}, placement, testing_support::RoundForces(), testing_support::Trocar18(),
      testing_support::RoundElasticity(),
      // A hair off the layers, so that rounding does not decide what is at a node.
      [&](const Vector3d& p) { return at(turn.inverse() * p + Vector3d(0, 0, 1e-9)); });
  Insertion a{upright};
  Insertion b{turned};
  a.axis = Vector3d(0.05, 0, 1);
  b.axis = turn.linear() * a.axis;
  for (int i = 1; i <= 400; ++i) {
    const Vector3d p(0.8 + 0.005 * i, 0.3, -1 + 0.1 * i);
    a.StepTo(p);
    b.StepTo(turn * p);
    const double size = a.last.force_in_ct_n.norm();
    ASSERT_LT((turn.linear() * a.last.force_in_ct_n - b.last.force_in_ct_n).norm(),
              1e-6 * (1 + size))
        << i;
  }
  EXPECT_NEAR(std::abs(b.state.out_of_plane_mm), 0.3, 1e-9);
}

// A needle that goes in at an angle to the grid meets what one along it meets.
TEST(PlaneModel2010, AnAngleToTheGridHardlyMatters) {
  const Layers body{{{-100, "fat"}}};  // No skin to be met at an angle: all is tissue.
  double plateau_n[2] = {};
  int n = 0;
  for (const double angle : {0.0, 0.5}) {
    const PlaneModel2010 model = Model({{{0, "fat"}}});
    Insertion insertion{model};
    insertion.axis = Vector3d(std::sin(angle), 0, std::cos(angle));
    insertion.tip_mm = -1.0 * insertion.axis;
    insertion.MoveTo(50.0 * insertion.axis);
    EXPECT_NEAR(insertion.last.cutting_n, 0.4, 5e-3);
    plateau_n[n++] = insertion.last.AxialN();
  }
  EXPECT_NEAR(plateau_n[0], plateau_n[1], 0.02);
}

TEST(PlaneModel2010, WhatIsOutOfThePlaneIsProjectedAndReported) {
  const PlaneModel2010 model = Model({{{0, "fat"}}});
  Insertion straight{model};
  Insertion beside{model};
  beside.tip_mm.y() = 3.0;
  straight.MoveToDepth(30.0);
  beside.MoveToDepth(30.0);
  EXPECT_NEAR(beside.last.AxialN(), straight.last.AxialN(), 1e-9);
  EXPECT_NEAR(std::abs(beside.state.out_of_plane_mm), 3.0, 1e-12);
  beside.axis = Vector3d(0, 0.1, 1).normalized();
  beside.StepTo(beside.tip_mm);
  EXPECT_NEAR(std::abs(beside.state.out_of_plane_rad), std::atan(0.1), 1e-9);
}

TEST(PlaneField2010, IsExactInTheNodesAndContinuous) {
  const PlaneModel2010 model = Model({{{0, "skin"}, {2, "fat"}}});
  Insertion insertion{model};
  PlaneField2010 field(model);
  TissueLoad load;
  for (const double z : {3.0, 35.0}) {
    insertion.MoveToDepth(z);
    model.LoadOf(insertion.state, load);
    field.Update(load);
    for (int q = 0; q < insertion.state.num_nodes; ++q) {
      const Vector3d moved = field.DisplacementMm(load.point[q].rest_in_ct_mm);
      EXPECT_NEAR(moved.z(), insertion.state.contact.DisplacementMm(2 * q), 1e-10);
      const Vector3d beside =
          field.DisplacementMm(load.point[q].rest_in_ct_mm + Vector3d(0, 10, 0));
      EXPECT_NEAR((beside - 0.5 * moved).norm(), 0.0, 1e-9);  // Half way out of the plane.
    }
    for (const double y : {0.0, 12.0}) {
      for (const double x : {0.0, 1.3, -20.0, 44.9}) {
        Vector3d before = Vector3d::Zero();
        for (double d = -15.0; d < 95.0; d += 0.01) {
          const Vector3d now = field.DisplacementMm(Vector3d(x, y, d));
          ASSERT_LT((now - before).norm(), 0.03) << x << " " << d;
          before = now;
        }
      }
      for (const double d : {-5.0, 0.0, 1.0, 33.0}) {
        Vector3d before = Vector3d::Zero();
        for (double x = -46.0; x < 46.0; x += 0.01) {
          const Vector3d now = field.DisplacementMm(Vector3d(x, y, d));
          ASSERT_LT((now - before).norm(), 0.03) << x << " " << d;
          before = now;
        }
      }
    }
  }
  EXPECT_EQ(field.DisplacementMm(Vector3d(0, 20, 5)).norm(), 0.0);
  field.Update(TissueLoad());
  EXPECT_EQ(field.DisplacementMm(Vector3d(0, 0, 5)).norm(), 0.0);
}

TEST(PlaneModel2010, SaysWhatIsWrong) {
  const Layers fat{{{0, "fat"}}};
  const double nan = std::nan("");
  for (const double bad : {0.0, -1.0, nan}) {
    for (double PlaneSettings::*field :
         {&PlaneSettings::spacing_mm, &PlaneSettings::width_mm, &PlaneSettings::depth_mm,
          &PlaneSettings::lateral_limit_n_per_mm, &PlaneSettings::image_fade_mm,
          &PlaneSettings::force_error_n}) {
      PlaneSettings settings;
      settings.*field = bad;
      EXPECT_THROW(Model(fat, settings), InputError);
    }
    PlaneSettings settings;
    settings.thickness_mm = bad - 0.1;
    EXPECT_THROW(Model(fat, settings), InputError);
    settings = {};
    settings.above_mm = bad - 0.1;
    EXPECT_THROW(Model(fat, settings), InputError);
  }
  PlaneSettings fine;
  fine.spacing_mm = 0.3;
  EXPECT_THROW(Model(fat, fine), InputError);  // Too many nodes for an explicit inverse.
  PlanePlacement parallel;
  parallel.across_in_ct = Vector3d(0, 0, -2);
  EXPECT_THROW(Model(fat, {}, parallel), InputError);
  EXPECT_THROW(Model({{{0, "kidney"}}}), InputError);   // No row in the elasticity table.
  EXPECT_THROW(Model({{{500, "fat"}}}), InputError);    // Nothing there.
  EXPECT_THROW(Model({{{-500, "bone"}}}), InputError);  // Nothing moves.
}

/// A probe beside the needle whose image contains the needle's axis, turned about it.
ToolSample Sampled(double time_s, double z_mm, double turn_rad,
                   const Vector3d& aside_mm = {0, 0, 0}) {
  ToolSample sample;
  sample.time_s = time_s;
  sample.tip_in_ct_mm = Vector3d(0, 0, z_mm) + aside_mm;
  sample.axis_in_ct = Vector3d::UnitZ();
  sample.probe_valid = true;
  sample.ct_from_probe.linear().col(0) = Vector3d(std::cos(turn_rad), std::sin(turn_rad), 0.0);
  sample.ct_from_probe.linear().col(1) = Vector3d::UnitZ();
  sample.ct_from_probe.linear().col(2) =
      sample.ct_from_probe.linear().col(0).cross(Vector3d::UnitZ());
  return sample;
}

TEST(TurnedPlane, LiesInTheImageThroughTheNeedleAndShowsItsTissueUnfaded) {
  const PlaneModel2010 model = Model(kSkinAndFat, {.num_turned = 4});
  for (const double turn : {0.0, 0.3, 1.2, 1.57, 2.9, 4.0}) {
    const Vector3d in_image(std::cos(turn), std::sin(turn), 0.0);
    const Vector3d across(-in_image.y(), in_image.x(), 0.0);
    const Vector3d aside_mm = 4.0 * across;  // Of the planned way.
    PlaneState state = model.NewState();
    forces::NeedleForce force;
    for (int n = 0; n <= 400; ++n) {
      force = model.Step(state, Sampled(0.001 * n, -2.0 + 0.06 * n, turn, aside_mm));
    }
    EXPECT_GT(force.AxialN(), 0.3);
    EXPECT_NEAR(state.out_of_plane_mm, 0.0, 1e-12);
    EXPECT_NEAR(state.out_of_plane_rad, 0.0, 1e-12);
    TissueLoad load;
    model.LoadOf(state, load);
    PlaneField2010 field(model);
    field.Update(load);
    const Vector3d tip_mm = Vector3d(0, 0, 15.0) + aside_mm;
    const double beside = field.DisplacementMm(tip_mm + 15.0 * in_image).z();
    EXPECT_GT(beside, 0.02) << turn;
    EXPECT_NEAR(field.DisplacementMm(tip_mm - 15.0 * in_image).z(), beside, 0.1 * beside);
    EXPECT_LT(std::abs(field.DisplacementMm(tip_mm + 21.0 * across).z()), 1e-12);
  }
}

// Homogeneous tissue is the same from all sides, and a probe that turns beside a needle in the
// tissue changes nothing.
TEST(TurnedPlane, TurningTheProbeNeverChangesTheForceOfANeedleInTheTissue) {
  const PlaneModel2010 still = Model(kSkinAndFat);
  const PlaneModel2010 turned = Model(kSkinAndFat, {.num_turned = 4});
  PlaneState of_still = still.NewState();
  PlaneState of_one = turned.NewState();
  PlaneState of_turning = turned.NewState();
  for (int n = 0; n <= 1500; ++n) {
    const double z_mm = -2.0 + 30.0 * std::sin(0.003 * n);
    const double start = 0.9;
    const double turn = z_mm > 1.0 ? start + 0.01 * n : start;
    const auto a = still.Step(of_still, Sampled(0.001 * n, z_mm, 0.0));
    const auto b = turned.Step(of_one, Sampled(0.001 * n, z_mm, start));
    const auto c = turned.Step(of_turning, Sampled(0.001 * n, z_mm, turn));
    ASSERT_NEAR(a.AxialN(), b.AxialN(), 1e-6) << n;
    ASSERT_EQ(b.force_in_ct_n, c.force_in_ct_n) << n;
  }
}

TEST(TurnedPlane, WithoutAProbeItIsThePlannedOneBitForBit) {
  const PlaneModel2010 still = Model(kSkinAndFat);
  const PlaneModel2010 turned = Model(kSkinAndFat, {.num_turned = 3});
  PlaneState a = still.NewState();
  PlaneState b = turned.NewState();
  for (int n = 0; n <= 800; ++n) {
    ToolSample sample = Sampled(0.001 * n, -2.0 + 40.0 * std::sin(0.003 * n), 0.4, {2, 1, 0});
    const auto of_still = still.Step(a, sample);
    sample.probe_valid = false;
    ASSERT_EQ(of_still.force_in_ct_n, turned.Step(b, sample).force_in_ct_n);
  }
}

TEST(TurnedPlane, IgnoresANeedleAcrossTheImageAndProbesThatAreNone) {
  const PlaneModel2010 model = Model(kSkinAndFat, {.num_turned = 4});
  PlaneState state = model.NewState();
  ToolSample sample = Sampled(0.0, -2.0, 0.0);
  sample.ct_from_probe.linear() << 1, 0, 0, 0, 1, 0, 0, 0, 1;  // Its image lies across the needle.
  model.Step(state, sample);
  EXPECT_EQ(state.frame.ct_from_plane, model.planes().planned().ct_from_plane);
  sample.time_s = 0.001;
  sample.ct_from_probe.linear().setConstant(std::nan(""));
  model.Step(state, sample);
  EXPECT_TRUE(state.frame.ct_from_plane.allFinite());
}

}  // namespace
}  // namespace acus::tissue
