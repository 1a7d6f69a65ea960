// Hard cases of the bendable needle, each with a bound.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/needle/bendable_needle.h"
#include "acus/physics/needle/rod.h"
#include "support/allocation_counter.h"
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
using Eigen::Vector3d;
using testing_support::Channel;
using testing_support::Input;
using testing_support::Inserted;
using testing_support::kBending;
using testing_support::kLengthMm;
using testing_support::LargestDifferenceMm;
using testing_support::Rod;
using testing_support::SameBits;
using testing_support::TipMm;
using testing_support::TipSpring;

TEST(NeedleRod, EveryNumberOfNodesGivesOneShapeInTissue) {
  const HardCase hard("15, 25, 50 and 100 nodes are one needle, bent by tissue and hand.");
  BoundPlot plot{.title = "Shape against 1201 nodes",
                 .x_label = "nodes",
                 .y_label = "largest distance [mm]",
                 .log_x = true,
                 .log_y = true,
                 .curves = {{}}};
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
    Largest off_mm;
    for (double arc_mm = 0.0; arc_mm <= kLengthMm; arc_mm += 5.0) {
      off_mm.Add((model.PositionMm(state, arc_mm) - fine.PositionMm(reference, arc_mm)).norm());
    }
    plot.curves[0].Add(num_nodes, off_mm);
    hard.Expect(Message("shape against 1201 nodes, ", num_nodes, " nodes"), off_mm,
                AtMost(0.005 * bent_mm), "mm");
    hard.Expect(Message("force on the hub against 1201 nodes, ", num_nodes, " nodes"),
                (result.base_force_n - reference.last.base_force_n).norm(),
                AtMost(0.01 * reference.last.base_force_n.norm()), "N");
  }
  hard.Plot(plot);
}

TEST(NeedleRod, AtRestNothingChangesAndEnergyNeverGrows) {
  const HardCase hard("At rest no bit changes; on the way there energy only falls.");
  Largest iterations;
  int num_changed = 0;
  BoundPlot plot{.title = "Energy of a rod that is given one iteration a call",
                 .x_label = "call",
                 .y_label = "energy above rest [N mm]",
                 .log_y = true,
                 .curves = {{}}};
  const Inserted inserted;
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  ASSERT_TRUE(model.Solve(state, inserted.input()).converged());
  const RodState settled = state;
  for (int i = 0; i < 1000; ++i) {
    const RodResult result = model.Solve(state, inserted.input());
    iterations.Add(result.iterations);
    num_changed += SameBits(state, settled) ? 0 : 1;
  }
  hard.Expect("iterations of a call at rest", iterations, Exactly(0));
  hard.Expect("calls at rest that changed a bit, of 1000", num_changed, Exactly(0));
  // Held to one step a call, it falls from call to call.
  RodOptions one;
  one.max_iterations = 1;
  one.tolerance_mm = 1e-9;
  const RodModel hurried(model.properties(), one);
  state = hurried.NewState();
  double energy = std::numeric_limits<double>::infinity();
  Largest growth;
  for (int i = 0; i < 50; ++i) {
    const RodResult result = hurried.Solve(state, inserted.input());
    growth.Add(result.energy_n_mm / energy - 1.0);
    energy = result.energy_n_mm;
    plot.curves[0].Add(i, energy - settled.last.energy_n_mm);
  }
  EXPECT_TRUE(state.last.converged());
  hard.Expect("growth of energy from call to call, as a share", growth, AtMost(1e-12));
  hard.Expect("energy against that of one call, as a share",
              std::abs(energy - settled.last.energy_n_mm) / energy, AtMost(1e-5));
  hard.Plot(plot);
}

TEST(NeedleRod, ACopiedStateContinuesWithTheSameBits) {
  const HardCase hard("A state that is saved on the way goes on as the other, bit for bit.");
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
  hard.Expect("same bits after 200 steps", SameBits(state, copy), Exactly(1));
}

TEST(NeedleRod, AStepAllocatesNothing) {
  const HardCase hard("Memory taken in a step of 1 ms can make it late.");
  const RodModel model = Rod(25);
  RodState state = model.NewState();
  Inserted inserted;
  const long before = acus::testing_support::num_allocations;
  for (int i = 0; i < 500; ++i) {
    inserted.base.position_mm.x() = 8.0 * std::sin(0.02 * i) + (i % 50 == 0 ? 40.0 : 0.0);
    model.Solve(state, inserted.input());
  }
  const long allocated = acus::testing_support::num_allocations - before;
  hard.Expect("allocations in 500 steps with jumps", static_cast<double>(allocated), Exactly(0));
}

// The whole needle in a hand: in, leaning, back and forth, out, in again, with jumps and a bevel.
TEST(NeedleRod, AStepInAHandAllocatesNothing) {
  const HardCase hard("In, leaning, back and forth, out, in again, with jumps and a bevel.");
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
  hard.Expect("allocations in 6000 steps", static_cast<double>(allocated), Exactly(0));
  EXPECT_GT(buried, 2000);
}

// The way there does not matter, only where the hand is.
TEST(NeedleRod, StepSizeDoesNotMatter) {
  const HardCase hard("The same way in 1 to 10000 steps: only where the hand ends may matter.");
  Largest off_mm;
  Largest off_n;
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
    off_mm.Add(LargestDifferenceMm(state, reference));
    off_n.Add((state.last.base_force_n - reference.last.base_force_n).norm());
  }
  hard.Expect("shape", off_mm, Below(2e-3), "mm");
  hard.Expect("force on the hub", off_n, Below(1e-3), "N");
}

// What the hand puts in is what is stored: nothing is made, whatever way the hand takes.
TEST(NeedleRod, TheWorkOfTheHandIsTheEnergyStored) {
  const HardCase hard("A hand at random: what it puts in is what is stored; nothing is made.");
  Largest off_n_mm;
  BoundPlot plot{.title = "Work of a random hand and energy of the needle",
                 .x_label = "step",
                 .y_label = "[mJ]",
                 .curves = {{.name = "work of the hand"}, {.name = "energy stored"}}};
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
    off_n_mm.Add(std::abs(work_n_mm - (now.energy_n_mm - begin)));
    last = now;
    if (i % 40 != 0) continue;
    plot.curves[0].Add(i, work_n_mm);
    plot.curves[1].Add(i, now.energy_n_mm - begin);
  }
  EXPECT_GT(moved_n_mm, 1000.0);
  hard.Expect("work against energy, of 1 J moved", off_n_mm, AtMost(0.01), "mJ");
  hard.Plot(plot);
}

TEST(NeedleRod, StiffnessOfTissueFromAThousandthToAThousandfold) {
  const HardCase hard(
      "Every second spring of the tissue is up to 1000 times stiffer than the others.");
  for (const double contrast : {1.0, 10.0, 1000.0}) {
    const RodModel model = Rod(25);
    RodState state = model.NewState();
    auto contacts = Channel(50.0, 24, 0.3);
    for (std::size_t i = 0; i < contacts.size(); i += 2) contacts[i].stiffness_n_per_mm *= contrast;
    for (RodContact& contact : contacts) contact.anchor_mm.x() = 4.0;  // Off the hand's line.
    const RodResult result = model.Solve(state, Input(contacts));
    EXPECT_TRUE(result.converged()) << contrast;
    hard.Expect(Message("iterations, contrast ", contrast), result.iterations, AtMost(8));
    // Held ever more strictly in the channel.
    double off_mm = 0.0;
    for (std::size_t i = 8; i < contacts.size(); i += 2) {
      const Vector3d at = model.PositionMm(state, contacts[i].arc_mm);
      off_mm = std::max(off_mm, std::abs(at.x() - 4.0));
    }
    hard.Expect(Message("distance from the channel, contrast ", contrast), off_mm,
                Below(contrast > 100.0 ? 1e-3 : 0.15), "mm");
  }
}

TEST(NeedleRod, NothingOutsideAndNothingAtAll) {
  const HardCase hard("All of the needle in tissue; contacts beyond its ends; no contact at all.");
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
  hard.Expect("tip off its channel with the hub at the skin", std::abs(TipMm(state).x()),
              AtMost(0.02), "mm");
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
  hard.Expect("length of a free needle", std::abs(TipMm(free).z() - kLengthMm), AtMost(1e-12),
              "mm");
}

}  // namespace
}  // namespace acus::needle
