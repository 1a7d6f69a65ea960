// The bendable needle through jumps, turns and samples that are none, each with a bound.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/needle/rod.h"
#include "support/bound.h"
#include "support/inserted_rod.h"
#include "unit/physics/needle/rods.h"

namespace acus::needle {
namespace {

using acus::testing_support::AtMost;
using acus::testing_support::Below;
using acus::testing_support::BoundPlot;
using acus::testing_support::Exactly;
using acus::testing_support::HardCase;
using acus::testing_support::Largest;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing_support::Input;
using testing_support::Inserted;
using testing_support::kBending;
using testing_support::kLengthMm;
using testing_support::LargestDifferenceMm;
using testing_support::LongestStretchMm;
using testing_support::Rod;
using testing_support::SameBits;
using testing_support::TipLoad;
using testing_support::TipMm;

TEST(NeedleRod, PulledOutWhileBentItBecomesStraightWithoutAJump) {
  const HardCase hard("Drawn back while bent: the last of the tissue lets go of a loaded spring.");
  Largest iterations;
  Largest tip_step_mm;
  Largest force_step_n;
  BoundPlot plot{.title = "Force on the hub while a bent needle is drawn back",
                 .x_label = "drawn back [mm]",
                 .y_label = "force [N]",
                 .curves = {{}}};
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  RodBase base;
  base.position_mm = {10.0, 0.0, 0.0};
  double force_n = -1.0;
  Vector3d tip_mm = Vector3d::Zero();
  // Tissue from z = 75 up; the needle is drawn back along z. The last of the tissue gives way to
  // the spring of the needle, 3 EI / L^3: no step of the tip may be longer than what is lost
  // explains.
  const double step_mm = 0.02;
  const double give_mm = 10.0 * 0.3 * step_mm / (3 * kBending / std::pow(kLengthMm, 3));
  for (int i = 0; i <= 4000; ++i) {
    const double out_mm = step_mm * i;
    base.position_mm.z() = -out_mm;
    std::vector<RodContact> contacts;
    const double buried_mm = std::max(0.0, 75.0 - out_mm);
    if (buried_mm > 0.0) {
      for (int piece = 0; piece < 12; ++piece) {
        RodContact contact;
        contact.arc_mm = kLengthMm - buried_mm + (piece + 0.5) * buried_mm / 12;
        contact.anchor_mm = {0.0, 0.0, contact.arc_mm - out_mm};
        contact.free_axis = Vector3d::UnitZ();
        contact.stiffness_n_per_mm = 0.3 * buried_mm / 12;
        contacts.push_back(contact);
      }
    }
    RodInput input = Input(contacts);
    input.base = base;
    const RodResult result = model.Solve(state, input);
    ASSERT_TRUE(result.converged()) << out_mm;
    iterations.Add(result.iterations);
    if (i > 0) {
      tip_step_mm.Add((TipMm(state) - tip_mm).norm());
      force_step_n.Add(std::abs(result.base_force_n.norm() - force_n));
    }
    tip_mm = TipMm(state);
    force_n = result.base_force_n.norm();
    if (i % 10 == 0) plot.curves[0].Add(out_mm, force_n);
  }
  hard.Expect("iterations of a step", iterations, AtMost(4));
  hard.Expect("step of the tip", tip_step_mm, Below(give_mm), "mm");
  hard.Expect("step of the force", force_step_n, Below(10.0 * 0.3 * step_mm), "N");
  hard.Expect("force when out", force_n, Below(1e-6), "N");
  hard.Expect("tip off the straight line when out", std::abs(tip_mm.x() - 10.0), AtMost(1e-3),
              "mm");
  hard.Plot(plot);
}

TEST(NeedleRod, TurnedBy180DegreesAndBackItIsAsBefore) {
  const HardCase hard("The hand turns by 180 degrees in one step, about each axis, and back.");
  Largest stretch_mm;
  Largest off_mm;
  const Inserted inserted;
  const RodModel model = Rod(25);
  RodState settled = model.NewState();
  ASSERT_TRUE(model.Solve(settled, inserted.input()).converged());
  for (const Vector3d& axis : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0, 1, 0)}) {
    RodState state = settled;
    Inserted turned = inserted;
    turned.base.orientation =
        Quaterniond(Eigen::AngleAxisd(std::numbers::pi, axis)) * inserted.base.orientation;
    const RodResult result = model.Solve(state, turned.input());
    EXPECT_LE(result.iterations, model.options().max_iterations);
    stretch_mm.Add(LongestStretchMm(model, state));
    // It comes to rest in a few calls more, whatever way it had to turn.
    int calls = 0;
    while (!model.Solve(state, turned.input()).converged() && calls < 20) ++calls;
    EXPECT_TRUE(state.last.converged()) << axis.transpose();
    RodResult back = model.Solve(state, inserted.input());
    for (calls = 0; !back.converged() && calls < 20; ++calls) {
      back = model.Solve(state, inserted.input());
    }
    EXPECT_TRUE(back.converged()) << axis.transpose();
    off_mm.Add(LargestDifferenceMm(state, settled));
  }
  hard.Expect("stretch of the needle", stretch_mm, Below(1e-9), "mm");
  hard.Expect("shape when back", off_mm, Below(2e-3), "mm");
}

TEST(NeedleRod, JumpsOfFiftyMillimetresStayBoundedAndAreForgotten) {
  const HardCase hard(
      "2000 jumps of 50 mm and up to a radian, each from the shape of the one before.");
  Largest iterations;
  Largest stretch_mm;
  Largest off_mm;
  const Inserted calm;
  const RodModel model = Rod(25);
  RodState settled = model.NewState();
  ASSERT_TRUE(model.Solve(settled, calm.input()).converged());
  RodState state = settled;
  RandomStream random(11, "jumps");
  const auto unit = [&] {
    return Vector3d(random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5)
        .normalized();
  };
  int slow = 0;
  for (int i = 0; i < 2000; ++i) {
    Inserted wild = calm;
    wild.base.position_mm += 50.0 * unit();
    wild.base.orientation =
        Quaterniond(Eigen::AngleAxisd(random.Uniform(), unit())) * wild.base.orientation;
    const RodResult result = model.Solve(state, wild.input());
    ASSERT_TRUE(result.base_force_n.allFinite() && result.base_torque_n_mm.allFinite());
    iterations.Add(result.iterations);
    stretch_mm.Add(LongestStretchMm(model, state));
    slow += !result.converged();
    if (i % 10 == 9) {
      model.Solve(state, calm.input());
      ASSERT_TRUE(state.last.converged()) << i;
      off_mm.Add(LargestDifferenceMm(state, settled));
    }
  }
  hard.Expect("iterations of a step", iterations, AtMost(model.options().max_iterations));
  hard.Expect("stretch of the needle", stretch_mm, Below(1e-9), "mm");
  hard.Expect("shape one step after a jump", off_mm, Below(2e-3), "mm");
  hard.Expect("steps that did not converge, of 2000", slow, Below(4));
  EXPECT_EQ(state.num_not_converged, slow);
}

TEST(NeedleRod, WhatIsNotANumberIsRefusedAndChangesNothing) {
  const HardCase hard("NaN, infinite and absurd values in every field of the input.");
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  const Inserted good;
  model.Solve(state, good.input());
  const RodState before = state;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  int refused = 0;
  const auto expect_refused = [&](const RodInput& input) {
    const RodResult result = model.Solve(state, input);
    EXPECT_EQ(result.status, RodStatus::kRejected);
    EXPECT_EQ(state.num_rejected, ++refused);
    EXPECT_TRUE(SameBits(state, before));
  };
  for (const double bad : {nan, inf, -inf}) {
    Inserted sick = good;
    sick.base.position_mm.y() = bad;
    expect_refused(sick.input());
    sick = good;
    sick.base.orientation.x() = bad;
    expect_refused(sick.input());
    for (const int part : {0, 1, 2, 3}) {
      sick = good;
      RodContact& contact = sick.contacts[5];
      (part == 0   ? contact.arc_mm
       : part == 1 ? contact.anchor_mm.z()
       : part == 2 ? contact.free_axis.x()
                   : contact.stiffness_n_per_mm) = bad;
      expect_refused(sick.input());
    }
    const RodLoad load{bad, {0.0, 0.0, 0.0}};
    expect_refused(Input({}, {&load, 1}));
    const RodLoad force = TipLoad({0.0, bad, 0.0});
    expect_refused(Input({}, {&force, 1}));
  }
  Inserted sick = good;
  sick.contacts[0].stiffness_n_per_mm = -1.0;
  expect_refused(sick.input());
  sick = good;
  sick.base.orientation.coeffs().setZero();
  expect_refused(sick.input());
  sick = good;
  sick.base.sprung = true;  // With no stiffness.
  expect_refused(sick.input());
  sick = good;
  sick.contacts[0].stiffness_n_per_mm = 1e10;
  expect_refused(sick.input());
  sick = good;
  sick.contacts[0].anchor_mm.x() = 1e300;
  expect_refused(sick.input());
  const RodLoad planet = TipLoad({0.0, 1e9, 0.0});
  expect_refused(Input({}, {&planet, 1}));
  sick = good;
  sick.contacts.resize(model.max_actions() + 1, sick.contacts[0]);
  expect_refused(sick.input());
  EXPECT_TRUE(model.Solve(state, good.input()).converged());
  hard.Expect("inputs refused", refused, Exactly(31));
  hard.Expect("shape after all of them", LargestDifferenceMm(state, before), Below(1e-9), "mm");
}

// Held by springs, the hub follows the hand through jumps and turns as a clamped one does.
TEST(NeedleRod, ASprungHubSurvivesJumpsAndTurns) {
  const HardCase hard("A hub on springs, through jumps of 50 mm and turns by 180 degrees.");
  Largest stretch_mm;
  Largest off_mm;
  const RodModel model = Rod(25);
  Inserted calm;
  calm.base.sprung = true;
  calm.base.stiffness_n_per_mm = 0.5;
  calm.base.stiffness_n_mm_per_rad = 2000.0;
  RodState settled = model.NewState();
  ASSERT_TRUE(model.Solve(settled, calm.input()).converged());
  RodState state = settled;
  RandomStream random(23, "hand");
  const auto unit = [&] {
    return Vector3d(random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5)
        .normalized();
  };
  int slow = 0;
  for (int i = 0; i < 1000; ++i) {
    Inserted wild = calm;
    wild.base.position_mm += 50.0 * unit();
    const double turn_rad = i % 5 == 0 ? std::numbers::pi : random.Uniform();
    wild.base.orientation =
        Quaterniond(Eigen::AngleAxisd(turn_rad, unit())) * wild.base.orientation;
    const RodResult result = model.Solve(state, wild.input());
    ASSERT_TRUE(result.base_force_n.allFinite() && result.base_torque_n_mm.allFinite());
    stretch_mm.Add(LongestStretchMm(model, state));
    slow += !result.converged();
    if (i % 10 == 9) {
      for (int calls = 0; calls < 4; ++calls) model.Solve(state, calm.input());
      ASSERT_TRUE(state.last.converged()) << i;
      off_mm.Add(LargestDifferenceMm(state, settled));
    }
  }
  hard.Expect("stretch of the needle", stretch_mm, Below(1e-9), "mm");
  hard.Expect("shape four steps after a jump", off_mm, Below(2e-3), "mm");
  hard.Expect("steps that did not converge, of 1000", slow, Below(20));
}

// A soft spring leaves the hub far from the hand for good; that is rest, not a jump a step.
TEST(NeedleRod, ASoftlySprungHubComesToRestFarFromTheHand) {
  const HardCase hard("A soft spring leaves the hub far from the hand: that is rest, not a jump.");
  int num_changed = 0;
  const RodModel model = Rod(25);
  Inserted hand;
  hand.base.position_mm = {40.0, 0.0, 0.0};
  hand.base.sprung = true;
  hand.base.stiffness_n_per_mm = 0.01;
  hand.base.stiffness_n_mm_per_rad = 100.0;
  RodState state = model.NewState();
  ASSERT_TRUE(model.Solve(state, hand.input()).converged());
  ASSERT_GT((state.point[0].position_mm - hand.base.position_mm).norm(), 10.0);
  const RodState settled = state;
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(model.Solve(state, hand.input()).iterations, 0);
    num_changed += SameBits(state, settled) ? 0 : 1;
  }
  hard.Expect("calls at rest that changed a bit", num_changed, Exactly(0));
}

TEST(NeedleRod, TheLengthOfAFreeAxisDoesNotMatter) {
  const RodModel model = Rod(25);
  Inserted one;
  Inserted other;
  for (RodContact& contact : other.contacts) contact.free_axis *= 8.0;
  RodState a = model.NewState();
  RodState b = model.NewState();
  model.Solve(a, one.input());
  model.Solve(b, other.input());
  EXPECT_LT(LargestDifferenceMm(a, b), 1e-9);
}

// A load far beyond what any needle bears: bounded, and gone when it is gone.
TEST(NeedleRod, AnyLoadIsBornOrCountedAndForgotten) {
  const HardCase hard(
      "Loads of 1 mN to 1 kN anywhere: far beyond buckling and what a needle bears.");
  Largest stretch_mm;
  Largest lever;
  const RodModel model = Rod(25);
  RandomStream random(5, "loads");
  RodState state = model.NewState();
  for (int i = 0; i < 500; ++i) {
    const double size_n = std::pow(10.0, 6.0 * random.Uniform() - 3.0);
    const RodLoad load{
        kLengthMm * random.Uniform(),
        size_n * Vector3d(random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5)};
    const RodResult result = model.Solve(state, Input({}, {&load, 1}));
    ASSERT_TRUE(result.base_torque_n_mm.allFinite());
    stretch_mm.Add(LongestStretchMm(model, state));
    lever.Add(result.base_torque_n_mm.norm() / (load.force_n.norm() * kLengthMm));
  }
  hard.Expect("stretch of the needle", stretch_mm, Below(1e-9), "mm");
  hard.Expect("torque at the hub, of the load at full length", lever, AtMost(1.0001));
  // Beyond 100 N, where a needle is tied into loops.
  hard.Expect("loads without an answer, of 500", state.num_not_converged, AtMost(5));
  RodResult result = model.Solve(state, {});
  for (int calls = 0; !result.converged() && calls < 20; ++calls) result = model.Solve(state, {});
  EXPECT_TRUE(result.converged());
  hard.Expect("length when all loads are gone", std::abs(TipMm(state).z() - kLengthMm),
              AtMost(1e-3), "mm");
}

}  // namespace
}  // namespace acus::needle
