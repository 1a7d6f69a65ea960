// Hard cases of the bendable needle, each with a bound.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "needle/bendable_needle.h"
#include "needle/rod.h"
#include "support/allocation_counter.h"
#include "unit/needle/rods.h"

namespace acus::needle {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing_support::Channel;
using testing_support::Input;
using testing_support::kBending;
using testing_support::kLengthMm;
using testing_support::Rod;
using testing_support::TipLoad;
using testing_support::TipMm;

RodContact TipSpring(const Vector3d& anchor_mm, double stiffness_n_per_mm) {
  RodContact tip;
  tip.arc_mm = kLengthMm;
  tip.anchor_mm = anchor_mm;
  tip.stiffness_n_per_mm = stiffness_n_per_mm;
  return tip;
}

/// A needle whose front half is in tissue, bent by a hand that is not in line with its channel.
struct Inserted {
  std::vector<RodContact> contacts = Channel(75.0, 12, 0.3);
  RodBase base;

  Inserted() {
    contacts.push_back(TipSpring({0.0, 0.0, kLengthMm}, 0.5));
    base.position_mm = {8.0, -3.0, 0.5};
    base.orientation = Eigen::AngleAxisd(0.1, Vector3d::UnitY());
  }
  RodInput input() const {
    RodInput in = Input(contacts);
    in.base = base;
    return in;
  }
};

double LargestDifferenceMm(const RodState& a, const RodState& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.point.size(); ++i) {
    largest = std::max(largest, (a.point[i].position_mm - b.point[i].position_mm).norm());
  }
  return largest;
}

bool SameBits(const RodState& a, const RodState& b) {
  for (std::size_t i = 0; i < a.point.size(); ++i) {
    if (a.point[i].position_mm != b.point[i].position_mm) return false;
    if (a.point[i].orientation.coeffs() != b.point[i].orientation.coeffs()) return false;
    if (a.point[i].curvature_per_mm != b.point[i].curvature_per_mm) return false;
  }
  return a.last.base_force_n == b.last.base_force_n && a.last.energy_n_mm == b.last.energy_n_mm;
}

/// Largest distance between neighbours less their spacing: 0 for any shape of an inextensible rod,
/// whose chords are never longer than its arcs.
double LongestStretchMm(const RodModel& model, const RodState& state) {
  double longest = 0.0;
  for (std::size_t i = 1; i < state.point.size(); ++i) {
    const double chord = (state.point[i].position_mm - state.point[i - 1].position_mm).norm();
    longest = std::max(longest, chord - model.spacing_mm());
  }
  return longest;
}

TEST(NeedleRod, EveryNumberOfNodesGivesOneShapeInTissue) {
  const Inserted inserted;
  RodState reference;
  const RodModel fine = Rod(1201, 1e-6);
  reference = fine.NewState();
  ASSERT_TRUE(fine.Solve(reference, inserted.input()).converged());
  const double bent_mm =
      (TipMm(reference) -
       (inserted.base.position_mm + kLengthMm * (inserted.base.orientation * Vector3d::UnitZ())))
          .norm();
  ASSERT_GT(bent_mm, 5.0);
  for (const int num_nodes : {15, 25, 50, 100}) {
    const RodModel model = Rod(num_nodes, 1e-6);
    RodState state = model.NewState();
    const RodResult result = model.Solve(state, inserted.input());
    ASSERT_TRUE(result.converged());
    for (double arc_mm = 0.0; arc_mm <= kLengthMm; arc_mm += 5.0) {
      EXPECT_NEAR((model.PositionMm(state, arc_mm) - fine.PositionMm(reference, arc_mm)).norm(),
                  0.0, 0.005 * bent_mm)
          << num_nodes << " nodes at " << arc_mm;
    }
    EXPECT_NEAR((result.base_force_n - reference.last.base_force_n).norm(), 0.0,
                0.01 * reference.last.base_force_n.norm())
        << num_nodes;
  }
}

TEST(NeedleRod, AtRestNothingChangesAndEnergyNeverGrows) {
  const Inserted inserted;
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  ASSERT_TRUE(model.Solve(state, inserted.input()).converged());
  const RodState settled = state;
  for (int i = 0; i < 1000; ++i) {
    const RodResult result = model.Solve(state, inserted.input());
    ASSERT_EQ(result.iterations, 0);
    ASSERT_TRUE(SameBits(state, settled));
  }
  // Held to one step a call, it falls from call to call.
  RodOptions one;
  one.max_iterations = 1;
  one.tolerance_mm = 1e-9;
  const RodModel hurried(model.properties(), one);
  state = hurried.NewState();
  double energy = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 50; ++i) {
    const RodResult result = hurried.Solve(state, inserted.input());
    ASSERT_LE(result.energy_n_mm, energy * (1.0 + 1e-12));
    energy = result.energy_n_mm;
  }
  EXPECT_TRUE(state.last.converged());
  EXPECT_NEAR(energy, settled.last.energy_n_mm, 1e-5 * energy);
}

TEST(NeedleRod, ACopiedStateGoesOnWithTheSameBits) {
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  Inserted inserted;
  RandomStream random(3, "hand");
  RodState copy;
  for (int i = 0; i < 400; ++i) {
    if (i == 200) copy = state;
    inserted.base.position_mm +=
        0.2 * Vector3d(random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5);
    model.Solve(state, inserted.input());
  }
  Inserted again;
  RandomStream same(3, "hand");
  for (int i = 0; i < 400; ++i) {
    again.base.position_mm +=
        0.2 * Vector3d(same.Uniform() - 0.5, same.Uniform() - 0.5, same.Uniform() - 0.5);
    if (i >= 200) model.Solve(copy, again.input());
  }
  EXPECT_TRUE(SameBits(state, copy));
}

TEST(NeedleRod, AStepAllocatesNothing) {
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  Inserted inserted;
  const long before = acus::testing_support::num_allocations;
  for (int i = 0; i < 500; ++i) {
    inserted.base.position_mm.x() = 8.0 * std::sin(0.02 * i) + (i % 50 == 0 ? 40.0 : 0.0);
    model.Solve(state, inserted.input());
  }
  const long allocated = acus::testing_support::num_allocations - before;
  EXPECT_EQ(allocated, 0);
}

// The whole needle in a hand: in, leaning, back and forth, out, in again, with jumps and a bevel.
TEST(NeedleRod, AStepInAHandAllocatesNothing) {
  RodProperties properties;
  properties.length_mm = kLengthMm;
  properties.bending_n_mm2 = kBending;
  properties.twist_n_mm2 = kBending / 1.3;
  BendableNeedleOptions options;
  options.bevel.curvature_per_mm = 0.0045;
  const BendableNeedle needle(properties, options);
  BendableNeedleState state = needle.NewState();
  BendableNeedleInput input;
  input.tissue.stiffness_n_per_mm2 = 0.2;
  const long before = acus::testing_support::num_allocations;
  double depth_mm = -5.0;
  int buried = 0;
  for (int i = 0; i < 6000; ++i) {
    const double next_mm = 40.0 * std::sin(0.004 * i) + 5.0 * std::sin(0.03 * i);
    input.tip_mm = {i % 700 == 0 ? 30.0 : 1.0 * std::sin(0.01 * i), 0.0, next_mm};
    input.hand = Eigen::AngleAxisd(0.2 * std::sin(0.013 * i), Vector3d::UnitY());
    input.touches = next_mm >= 0.0;
    input.advance_mm = std::max(0.0, next_mm) - std::max(0.0, depth_mm);
    depth_mm = next_mm;
    const BendableNeedleStep step = needle.Step(state, input);
    ASSERT_TRUE(step.hand_force_n.allFinite());
    buried += !state.path.empty();
  }
  const long allocated = acus::testing_support::num_allocations - before;
  EXPECT_EQ(allocated, 0);
  EXPECT_GT(buried, 2000);
}

// The way there does not matter, only where the hand is.
TEST(NeedleRod, StepSizeDoesNotMatter) {
  const RodModel model = Rod(25);
  RodState reference = model.NewState();
  Inserted end;
  end.base.position_mm = {-6.0, 9.0, 0.8};
  end.base.orientation = Eigen::AngleAxisd(-0.08, Vector3d::UnitX());
  ASSERT_TRUE(model.Solve(reference, end.input()).converged());
  for (const int steps : {1, 3, 10, 100, 1000, 10000}) {
    RodState state = model.NewState();
    Inserted hand;
    model.Solve(state, hand.input());
    const RodBase begin = hand.base;
    for (int i = 1; i <= steps; ++i) {
      const double f = static_cast<double>(i) / steps;
      hand.base.position_mm = (1 - f) * begin.position_mm + f * end.base.position_mm;
      hand.base.orientation = begin.orientation.slerp(f, end.base.orientation);
      ASSERT_TRUE(model.Solve(state, hand.input()).converged());
    }
    EXPECT_LT(LargestDifferenceMm(state, reference), 2e-3) << steps;
    EXPECT_LT((state.last.base_force_n - reference.last.base_force_n).norm(), 1e-3) << steps;
  }
}

// What the hand puts in is what is stored: nothing is made, whatever way the hand takes.
TEST(NeedleRod, TheWorkOfTheHandIsTheEnergyStored) {
  const RodModel model = Rod(25, 1e-5);
  RodState state = model.NewState();
  Inserted hand;
  RodResult last = model.Solve(state, hand.input());
  const double begin = last.energy_n_mm;
  RandomStream random(17, "hand");
  Vector3d speed_mm = Vector3d::Zero();
  Vector3d turn_rad = Vector3d::Zero();
  const auto kick = [&] {
    return Vector3d(random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5);
  };
  double work_n_mm = 0.0;
  double moved_n_mm = 0.0;
  for (int i = 0; i < 20000; ++i) {
    speed_mm = 0.99 * speed_mm + 0.01 * kick() - 1e-4 * (hand.base.position_mm - Vector3d(4, 0, 0));
    turn_rad = 0.99 * turn_rad + 1e-4 * kick();
    hand.base.position_mm += speed_mm;
    hand.base.orientation = TurnQuaternion(turn_rad) * hand.base.orientation;
    const RodResult now = model.Solve(state, hand.input());
    ASSERT_TRUE(now.converged()) << i;
    const double step_n_mm = -0.5 * ((last.base_force_n + now.base_force_n).dot(speed_mm) +
                                     (last.base_torque_n_mm + now.base_torque_n_mm).dot(turn_rad));
    work_n_mm += step_n_mm;
    moved_n_mm += std::abs(step_n_mm);
    ASSERT_NEAR(work_n_mm, now.energy_n_mm - begin, 0.01) << i;  // 10 uJ
    last = now;
  }
  EXPECT_GT(moved_n_mm, 1000.0);
}

TEST(NeedleRod, PulledOutWhileBentItBecomesStraightWithoutAJump) {
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
    ASSERT_LE(result.iterations, 4) << out_mm;
    if (i > 0) {
      ASSERT_LT((TipMm(state) - tip_mm).norm(), give_mm) << out_mm;
      ASSERT_LT(std::abs(result.base_force_n.norm() - force_n), 10.0 * 0.3 * step_mm) << out_mm;
    }
    tip_mm = TipMm(state);
    force_n = result.base_force_n.norm();
  }
  EXPECT_LT(force_n, 1e-6);
  EXPECT_NEAR(tip_mm.x(), 10.0, 1e-3);
}

TEST(NeedleRod, TurnedBy180DegreesAndBackItIsAsBefore) {
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
    EXPECT_LT(LongestStretchMm(model, state), 1e-9);
    // It comes to rest in a few calls more, whatever way it had to turn.
    int calls = 0;
    while (!model.Solve(state, turned.input()).converged() && calls < 20) ++calls;
    EXPECT_TRUE(state.last.converged()) << axis.transpose();
    RodResult back = model.Solve(state, inserted.input());
    for (calls = 0; !back.converged() && calls < 20; ++calls) {
      back = model.Solve(state, inserted.input());
    }
    EXPECT_TRUE(back.converged()) << axis.transpose();
    EXPECT_LT(LargestDifferenceMm(state, settled), 2e-3) << axis.transpose();
  }
}

TEST(NeedleRod, JumpsOfFiftyMillimetresStayBoundedAndAreForgotten) {
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
    ASSERT_LE(result.iterations, model.options().max_iterations);
    ASSERT_LT(LongestStretchMm(model, state), 1e-9);
    slow += !result.converged();
    if (i % 10 == 9) {
      model.Solve(state, calm.input());
      ASSERT_TRUE(state.last.converged()) << i;
      ASSERT_LT(LargestDifferenceMm(state, settled), 2e-3) << i;
    }
  }
  EXPECT_LT(slow, 4);
  EXPECT_EQ(state.num_not_converged, slow);
}

TEST(NeedleRod, StiffnessOfTissueFromAThousandthToAThousandfold) {
  for (const double contrast : {1.0, 10.0, 1000.0}) {
    const RodModel model = Rod(25);
    RodState state = model.NewState();
    auto contacts = Channel(50.0, 24, 0.3);
    for (std::size_t i = 0; i < contacts.size(); i += 2) contacts[i].stiffness_n_per_mm *= contrast;
    for (RodContact& contact : contacts) contact.anchor_mm.x() = 4.0;  // Off the hand's line.
    const RodResult result = model.Solve(state, Input(contacts));
    EXPECT_TRUE(result.converged()) << contrast;
    EXPECT_LE(result.iterations, 8) << contrast;
    // Held ever more strictly in the channel.
    double off_mm = 0.0;
    for (std::size_t i = 8; i < contacts.size(); i += 2) {
      const Vector3d at = model.PositionMm(state, contacts[i].arc_mm);
      off_mm = std::max(off_mm, std::abs(at.x() - 4.0));
    }
    EXPECT_LT(off_mm, contrast > 100.0 ? 1e-3 : 0.15) << contrast;
  }
}

TEST(NeedleRod, NothingOutsideAndNothingAtAll) {
  // The hub at the skin: the whole needle is in tissue.
  const RodModel model = Rod(25);
  auto whole = Channel(0.0, 30, 0.3);
  RodContact hub = whole[0];
  hub.arc_mm = 0.0;
  hub.anchor_mm = Vector3d::Zero();
  whole.push_back(hub);
  RodState state = model.NewState();
  RodInput input = Input(whole);
  input.base.position_mm = {0.5, 0.0, 0.0};
  EXPECT_TRUE(model.Solve(state, input).converged());
  EXPECT_NEAR(TipMm(state).x(), 0.0, 0.02);
  // Contacts beyond either end are at the end.
  RodContact beyond = TipSpring({1.0, 0.0, kLengthMm}, 1.0);
  beyond.arc_mm = 1e6;
  RodState a = model.NewState();
  model.Solve(a, Input({&beyond, 1}));
  beyond.arc_mm = kLengthMm;
  RodState b = model.NewState();
  model.Solve(b, Input({&beyond, 1}));
  EXPECT_TRUE(SameBits(a, b));
  // No contact and no load: straight, at once, in the exact bits of the base.
  RodState free = model.NewState();
  EXPECT_EQ(model.Solve(free, {}).iterations, 0);
  EXPECT_EQ(TipMm(free).x(), 0.0);
  EXPECT_NEAR(TipMm(free).z(), kLengthMm, 1e-12);
}

TEST(NeedleRod, WhatIsNotANumberIsRefusedAndChangesNothing) {
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
  EXPECT_LT(LargestDifferenceMm(state, before), 1e-9);
}

// Held by springs, the hub follows the hand through jumps and turns as a clamped one does.
TEST(NeedleRod, ASprungHubSurvivesJumpsAndTurns) {
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
    ASSERT_LT(LongestStretchMm(model, state), 1e-9);
    slow += !result.converged();
    if (i % 10 == 9) {
      for (int calls = 0; calls < 4; ++calls) model.Solve(state, calm.input());
      ASSERT_TRUE(state.last.converged()) << i;
      ASSERT_LT(LargestDifferenceMm(state, settled), 2e-3) << i;
    }
  }
  EXPECT_LT(slow, 20);  // 2 %
}

// A soft spring leaves the hub far from the hand for good; that is rest, not a jump a step.
TEST(NeedleRod, ASoftlySprungHubComesToRestFarFromTheHand) {
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
    ASSERT_TRUE(SameBits(state, settled));
  }
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
    ASSERT_LT(LongestStretchMm(model, state), 1e-9);
    ASSERT_LE(result.base_torque_n_mm.norm(), 1.0001 * load.force_n.norm() * kLengthMm);
  }
  EXPECT_LE(state.num_not_converged, 5);  // Beyond 100 N, where a needle is tied into loops.
  RodResult result = model.Solve(state, {});
  for (int calls = 0; !result.converged() && calls < 20; ++calls) result = model.Solve(state, {});
  EXPECT_TRUE(result.converged());
  EXPECT_NEAR(TipMm(state).z(), kLengthMm, 1e-3);
}

}  // namespace
}  // namespace acus::needle
