#include "acus/physics/needle/path_coupling.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "rods.h"

namespace acus::needle {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing_support::Input;
using testing_support::kLengthMm;
using testing_support::Rod;
using testing_support::TipMm;

PathNode PathCouplingTissue(double stiffness_n_per_mm2) {
  PathNode tissue;
  tissue.stiffness_n_per_mm2 = stiffness_n_per_mm2;
  return tissue;
}

CurvedPath StraightPath(double depth_mm, double stiffness_n_per_mm2) {
  CurvedPath path;
  path.Begin(PathCouplingTissue(stiffness_n_per_mm2));
  path.Advance(Vector3d::UnitZ(), depth_mm, PathCouplingTissue(stiffness_n_per_mm2));
  return path;
}

double Sum(std::span<const RodContact> contacts) {
  double sum = 0.0;
  for (const RodContact& contact : contacts) sum += contact.stiffness_n_per_mm;
  return sum;
}

TEST(CoupleToPath, HoldsWithTheStiffnessOfTheTissueWhateverTheNodes) {
  const CurvedPath path = StraightPath(40.3, 0.3);
  for (const int num_nodes : {15, 25, 50, 100}) {
    const RodModel model = Rod(num_nodes);
    std::vector<RodContact> contacts(num_nodes + 1);
    const int count = CoupleToPath(model, path, {.tip_stiffness_n_per_mm = 0.5}, contacts);
    EXPECT_NEAR(Sum({contacts.data(), static_cast<std::size_t>(count)}), 0.5 + 40.3 * 0.3, 1e-9);
    for (int i = 0; i < count; ++i) {
      // Matched by length from the tip.
      EXPECT_NEAR(contacts[i].anchor_mm.z(), contacts[i].arc_mm - (kLengthMm - 40.3), 1e-9);
      EXPECT_NEAR(contacts[i].free_axis.norm(), i == 0 ? 0.0 : 1.0, 1e-12);
    }
  }
}

TEST(CoupleToPath, ChangesWithoutAStepAsTheNeedleGoesIn) {
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  std::vector<RodContact> contacts(26);
  CurvedPath path;
  path.Begin(PathCouplingTissue(0.1));
  Vector3d force_n = Vector3d::Zero();
  for (int i = 0; i < 8000; ++i) {
    path.Advance(Vector3d::UnitZ(), 0.01, PathCouplingTissue(i < 3000 ? 0.1 : 1.0));
    const int count = CoupleToPath(model, path, {}, contacts);
    RodInput input = Input({contacts.data(), static_cast<std::size_t>(count)});
    input.base.position_mm = {6.0, 0.0, path.LengthMm() - kLengthMm};
    ASSERT_TRUE(model.Solve(state, input).converged()) << i;
    if (i > 0) {
      ASSERT_LT((state.last.base_force_n - force_n).norm(), 0.003) << path.LengthMm();
    }
    force_n = state.last.base_force_n;
  }
  EXPECT_GT(force_n.norm(), 0.5);
}

TEST(CoupleToPath, NothingOutsideAndOnlyTheTipOnTheSkin) {
  const RodModel model = Rod(25);
  std::vector<RodContact> contacts(26);
  CurvedPath path;
  EXPECT_EQ(CoupleToPath(model, path, {}, contacts), 0);
  path.Begin(PathCouplingTissue(0.3));
  EXPECT_EQ(CoupleToPath(model, path, {}, contacts), 1);
  EXPECT_EQ(contacts[0].arc_mm, kLengthMm);
  // Deeper than the needle is long: all of it is held, and never more contacts than there is room.
  EXPECT_EQ(CoupleToPath(model, StraightPath(200.0, 0.3), {}, contacts), 25);
  std::array<RodContact, 3> few;
  EXPECT_EQ(CoupleToPath(model, StraightPath(80.0, 0.3), {}, few), 3);
}

// The paper's case (fig. 8, upper): inserted 10 mm, angulated, inserted further: bent on a curve.
TEST(CoupleToPath, AnAngulatedNeedleFollowsACurve) {
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  std::vector<RodContact> contacts(26);
  CurvedPath path = StraightPath(10.0, 0.5);
  RodInput input;
  const auto solve = [&](double lean_rad) {
    const int count = CoupleToPath(model, path, {}, contacts);
    input.contacts = {contacts.data(), static_cast<std::size_t>(count)};
    const Quaterniond hand(Eigen::AngleAxisd(lean_rad, Vector3d::UnitY()));
    input.base = BaseFromHand(path.entry().position_mm, kLengthMm - path.LengthMm(), hand,
                              {.stiffness_n_per_mm = 1.0, .stiffness_n_mm_per_rad = 3000.0});
    ASSERT_TRUE(model.Solve(state, input).converged());
  };
  for (int i = 0; i <= 100; ++i) solve(0.002 * i);
  for (int i = 0; i < 600; ++i) {
    path.Advance(state.point.back().tangent, 0.1, PathCouplingTissue(0.5));
    solve(0.2);
  }
  // The path leaves straight in and turns towards where the hand points.
  EXPECT_NEAR(path.Direction(5.0).x(), 0.0, 1e-9);
  EXPECT_GT(path.tip().position_mm.x(), 1.0);
  EXPECT_GT(path.Direction(30.0).x(), 0.05);
  for (double at = 0.0; at < 70.0; at += 1.0) EXPECT_LT(path.Direction(at).x(), 0.2);
}

// A slender needle in stiff tissue goes where its bevel steers it.
TEST(BevelTip, ABendableNeedleFollowsItsBevel) {
  RodProperties wire;
  wire.length_mm = kLengthMm;
  wire.bending_n_mm2 = 600.0;  // 0.7 mm of nitinol, 50 GPa.
  wire.twist_n_mm2 = 460.0;
  const RodModel model(wire, {.num_nodes = 50});
  RodState state = model.NewState();
  std::vector<RodContact> contacts(51);
  CurvedPath path;
  path.Begin(PathCouplingTissue(1.0));
  const BevelTip bevel{.curvature_per_mm = 0.0045, .roll_rad = 0.0};
  Vector3d heading = Vector3d::UnitZ();
  for (int i = 0; i < 1000; ++i) {
    const Quaterniond tip = state.point.back().orientation;
    const auto next = bevel.After(0.1, heading, tip * Vector3d::UnitX(), tip * Vector3d::UnitY());
    heading = next.end;
    path.Advance(next.chord, 0.1, PathCouplingTissue(1.0));
    const int count = CoupleToPath(model, path, {.tip_stiffness_n_per_mm = 5.0}, contacts);
    RodInput input = Input({contacts.data(), static_cast<std::size_t>(count)});
    input.base.position_mm = {0.0, 0.0, path.LengthMm() - kLengthMm};
    ASSERT_TRUE(model.Solve(state, input).converged()) << i;
  }
  const Vector3d end((1 - std::cos(0.45)) / 0.0045, 0.0, std::sin(0.45) / 0.0045);
  EXPECT_NEAR((TipMm(state) - end).norm(), 0.0, 0.2);
  // A free end does not bend: over 1 / lambda its tangent stays behind the path's.
  const double lambda = std::pow(1.0 / (4 * 600.0), 0.25);
  EXPECT_NEAR(state.point.back().tangent.x(), std::sin(0.45), 0.0045 / lambda);
}

TEST(HandForce, IsTheOffsetAcrossThePathAndTurnsToTheNeedle) {
  const Vector3d force = HandForceN(0.5, {3.0, 4.0, 9.0}, {1.0, 4.0, 2.0}, Vector3d::UnitZ());
  EXPECT_NEAR((force - Vector3d(1.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  const Quaterniond hand(Eigen::AngleAxisd(0.7, Vector3d::UnitZ()));
  const Vector3d tangent(std::sin(0.3), 0.0, std::cos(0.3));
  const Vector3d torque = HandTorqueNMm(100.0, hand, tangent);
  EXPECT_NEAR((torque - Vector3d(0.0, 30.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_EQ(HandTorqueNMm(100.0, hand, Vector3d::UnitZ()), Vector3d::Zero());
}

}  // namespace
}  // namespace acus::needle
