// Hard cases of the bendable needle in a scene, each with a bound.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "references/closed_loop.h"
#include "support/allocation_counter.h"
#include "support/bending_scene.h"
#include "support/bound.h"
#include "support/stability_length.h"
#include "support/wild_hand.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;
using scenario::NeedleForceModelKind;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BendingScene;
using testing_support::BoundPlot;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::NeedleAt;

constexpr NeedleForceModelKind kSceneNeedleForces[] = {
    NeedleForceModelKind::kLayered, NeedleForceModelKind::kAlamilla, NeedleForceModelKind::kTissue};

const char* SceneNeedleNameOf(NeedleForceModelKind force) {
  if (force == NeedleForceModelKind::kTissue) return "tissue";
  return force == NeedleForceModelKind::kAlamilla ? "alamilla" : "layered";
}

Scene SceneWith(NeedleForceModelKind force, const char* tissue) {
  BendingScene bending;
  bending.force = force;
  bending.tissue = tissue;
  return bending.Make();
}

double SceneNeedleLargestN(const Scene& scene) {
  return scene.force_from_tissue ? 30.0 : scene.forces->table().settings.largest_force_n;
}

/// Nothing that is shown, felt or kept is anything but a number of reasonable size.
void SceneNeedleExpectSound(const Scene& scene, const State& state, const StepOutput& out) {
  ASSERT_TRUE(out.force.force_in_ct_n.allFinite());
  ASSERT_LE(out.force.force_in_ct_n.norm(), SceneNeedleLargestN(scene) * (1.0 + 1e-12));
  ASSERT_TRUE(out.force.torque_in_ct_n_mm.allFinite());
  ASSERT_LT(out.force.torque_in_ct_n_mm.norm(), 5000.0);
  ASSERT_TRUE(std::isfinite(out.shape.tip_deflection_mm));
  ASSERT_LE(out.shape.tip_deflection_mm, scene.needle->length_mm);
  math::Polyline line;
  if (!Simulation(scene).ShapeOf(state, line)) return;
  double length_mm = 0.0;
  for (int i = 1; i < line.num_points; ++i) length_mm += (line.At(i) - line.At(i - 1)).norm();
  ASSERT_LE(length_mm, scene.needle->length_mm + 1e-6);
}

// A minute of a hand that goes in and out, sideways, and turns: energy that the needle gives beyond
// what it took, with the force of a step held until the next.
TEST(BendableHardCases, ARandomHandGetsNoEnergy) {
  const HardCase hard("A minute in and out, sideways and turning: the bent needle stores energy.");
  for (const NeedleForceModelKind force : kSceneNeedleForces) {
    for (const std::uint64_t seed : {1u, 2u}) {
      const Scene scene = SceneWith(force, seed == 1 ? "muscle" : nullptr);
      const Simulation simulation(scene);
      State state = simulation.NewState();
      const double kDuration = 60.0;
      forces::RandomHand tip{.across_mm = 4.0};
      tip.to_mm = 60.0;
      forces::RandomHand lean{.across_mm = 0.25};
      lean.from_mm = lean.to_mm = 0.0;
      lean.tremor_mm = 0.002;
      const auto place = forces::RandomMotion(tip, kDuration, seed);
      const auto turn = forces::RandomMotion(lean, kDuration, 100 + seed);
      double balance_mj = 0.0, generated_mj = 0.0, returned_mj = 0.0;
      StepOutput before;
      for (int i = 0; i < 60000; ++i) {
        const double t = 1e-3 * i;
        const StepOutput out = simulation.Step(state, NeedleAt(t, place(t), turn(t)));
        const Vector3d moved_mm =
            out.ct_from_needle.translation() - before.ct_from_needle.translation();
        const Eigen::AngleAxisd turned(out.ct_from_needle.linear() *
                                       before.ct_from_needle.linear().transpose());
        const double work_mj = -before.force.force_in_ct_n.dot(moved_mm) -
                               before.force.torque_in_ct_n_mm.dot(turned.angle() * turned.axis());
        balance_mj += work_mj;
        returned_mj += std::max(0.0, -work_mj);
        generated_mj = std::max(generated_mj, -balance_mj);
        if (out.force.force_in_ct_n.isZero() && out.force.torque_in_ct_n_mm.isZero()) {
          balance_mj = 0.0;
        }
        before = out;
      }
      const std::string of = Message(", ", SceneNeedleNameOf(force), ", hand ", seed);
      hard.Expect("energy generated" + of, generated_mj, AtMost(0.2), "mJ");
      hard.Expect("energy given back of what it took" + of, returned_mj, Above(10.0), "mJ");
      EXPECT_EQ(state.shape.needle.rod.num_rejected, 0);
      std::printf("  force %d, hand %d: generated %.4f mJ, returned %.0f mJ\n",
                  static_cast<int>(force), static_cast<int>(seed), generated_mj, returned_mj);
    }
  }
}

TEST(BendableHardCases, ARandomHandAndABrokenTrackerStayBounded) {
  const HardCase hard(
      "Jumps, broken numbers, time that goes back, lost poses, with a needle that bends.");
  const int num_steps = testing_support::StabilitySteps(20000);
  for (const NeedleForceModelKind force : kSceneNeedleForces) {
    Largest force_share;
    Largest deflection_mm;
    const Scene scene = SceneWith(force, nullptr);
    const Simulation simulation(scene);
    State state = simulation.NewState();
    testing_support::WildHand hand(7);
    for (int i = 0; i < num_steps; ++i) {
      const forces::NeedleInput input = hand.Next();
      Sample sample{.needle_valid = input.valid};
      sample.time_ns = std::isfinite(input.time_s) && std::abs(input.time_s) < 1e9
                           ? std::llround(1e9 * input.time_s)
                           : std::numeric_limits<std::int64_t>::min();
      sample.reference_from_needle.linear().col(2) = input.axis_in_ct;
      sample.reference_from_needle.translation() = input.tip_in_ct_mm;
      const StepOutput out = simulation.Step(state, sample);
      SceneNeedleExpectSound(scene, state, out);
      if (HasFatalFailure()) FAIL() << "step " << i << ", force " << static_cast<int>(force);
      force_share.Add(out.force.force_in_ct_n.norm() / SceneNeedleLargestN(scene));
      deflection_mm.Add(out.shape.tip_deflection_mm);
    }
    hard.Expect(Message("largest force, of its limit, ", SceneNeedleNameOf(force)), force_share,
                AtMost(1.0 + 1e-12));
    hard.Expect(Message("deflection of the tip, ", SceneNeedleNameOf(force)), deflection_mm,
                AtMost(scene.needle->length_mm), "mm");
    hard.Note(Message("wild steps, ", SceneNeedleNameOf(force)), std::to_string(num_steps));
  }
}

TEST(BendableHardCases, BadSamplesAreDealtWithAsByTheForceModel) {
  const HardCase hard(
      "Time that goes back, no number, a lost needle: held, let go, and taken up again.");
  const Scene scene = SceneWith(NeedleForceModelKind::kLayered, "muscle");
  const Simulation simulation(scene);
  State state = simulation.NewState();
  StepOutput held;
  double t = 0.0;
  for (double z = -2.0; z < 30.0; z += 0.05)
    held = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, z}));
  for (int i = 1; i <= 100; ++i) {
    held = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, 30}, {0, 0.002 * i, 0}));
  }
  ASSERT_GT(held.force.lateral_n, 0.05);
  const auto same_shape = [&](const StepOutput& out) {
    return out.shape.bent && out.shape.tip_in_ct_mm == held.shape.tip_in_ct_mm &&
           out.shape.tip_deflection_mm == held.shape.tip_deflection_mm;
  };
  // Time goes back: the held force.
  StepOutput out = simulation.Step(state, NeedleAt(t - 0.01, {0, 0, 35}));
  EXPECT_EQ(out.force.force_in_ct_n, held.force.force_in_ct_n);
  EXPECT_EQ(out.force.torque_in_ct_n_mm, held.force.torque_in_ct_n_mm);
  EXPECT_TRUE(same_shape(out));
  // Not a number: no force, and the state stays.
  Sample broken = NeedleAt(t += 0.001, {0, std::nan(""), 30});
  out = simulation.Step(state, broken);
  EXPECT_TRUE(out.force.force_in_ct_n.isZero());
  EXPECT_TRUE(out.force.torque_in_ct_n_mm.isZero());
  EXPECT_TRUE(same_shape(out));
  // Lost: held, then let go.
  Sample lost = NeedleAt(t += 0.001, {500, 0, 0});
  lost.needle_valid = false;
  out = simulation.Step(state, lost);
  EXPECT_NEAR((out.force.force_in_ct_n - held.force.force_in_ct_n).norm(), 0.0, 1e-12);
  EXPECT_TRUE(same_shape(out));
  for (int i = 0; i < 2000; ++i) {
    lost.time_ns = std::llround(1e9 * (t += 0.001));
    out = simulation.Step(state, lost);
  }
  EXPECT_TRUE(out.force.force_in_ct_n.isZero());
  EXPECT_TRUE(out.force.torque_in_ct_n_mm.isZero());
  // And back where it was, it goes on.
  out = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, 30}, {0, 0.2, 0}));
  hard.Expect("force across when found again, change as a share",
              std::abs(out.force.lateral_n / held.force.lateral_n - 1.0), AtMost(0.02));
  hard.Expect("tip when found again", (out.shape.tip_in_ct_mm - held.shape.tip_in_ct_mm).norm(),
              AtMost(0.01), "mm");
}

TEST(BendableHardCases, PulledOutWhileBentItIsStraightAndTheForceHasNoJump) {
  const HardCase hard("Drawn out while bent: what the tissue held is let go little by little.");
  BoundPlot plot{.title = "Force across a bent needle that is drawn out",
                 .x_label = "drawn out [mm]",
                 .y_label = "force [N]"};
  for (const NeedleForceModelKind force : kSceneNeedleForces) {
    plot.curves.push_back({.name = SceneNeedleNameOf(force)});
    const Scene scene = SceneWith(force, "muscle");
    const Simulation simulation(scene);
    State state = simulation.NewState();
    double t = 0.0;
    StepOutput out;
    for (double z = -2.0; z < 40.0; z += 0.05) {
      out = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, z}));
    }
    for (int i = 1; i <= 300; ++i) {
      out = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, 40}, {0, 0.001 * i, 0}));
    }
    const double bent_mm = out.shape.tip_deflection_mm;
    EXPECT_GT(bent_mm, 0.5);
    const Vector3d axis(std::sin(0.3), 0.0, std::cos(0.3));
    Largest largest_step_n;
    for (int i = 1; i <= 2200; ++i) {
      const double before_n = out.force.lateral_n;
      out = simulation.Step(
          state, NeedleAt(t += 0.001, Vector3d(0, 0, 40) - 0.02 * i * axis, {0, 0.3, 0}));
      SceneNeedleExpectSound(scene, state, out);
      // What is still held when the tip leaves the skin is let go with it.
      if (out.shape.bent) {
        largest_step_n.Add(std::abs(out.force.lateral_n - before_n));
      }
      if (i % 5 == 0) plot.curves.back().Add(0.02 * i, out.force.lateral_n);
    }
    hard.Expect(Message("step of the force across, ", SceneNeedleNameOf(force)), largest_step_n,
                Below(0.05), "N");
    EXPECT_FALSE(out.shape.bent);
    hard.Expect(Message("force when out, ", SceneNeedleNameOf(force)),
                out.force.force_in_ct_n.norm(), Exactly(0), "N");
  }
  hard.Plot(plot);
}

TEST(BendableHardCases, TurnedBy180DegreesAndBackItIsAsBefore) {
  const HardCase hard("The hand turns by 180 degrees within a step, with the needle in tissue.");
  Largest tip_mm;
  Largest lateral_n;
  const Scene scene = SceneWith(NeedleForceModelKind::kLayered, "muscle");
  const Simulation simulation(scene);
  State state = simulation.NewState();
  double t = 0.0;
  StepOutput out;
  for (double z = -2.0; z < 40.0; z += 0.05) {
    out = simulation.Step(state, NeedleAt(t += 0.001, {0, 0, z}));
  }
  const StepOutput before = out;
  for (const Vector3d& turn : {Vector3d(std::numbers::pi, 0, 0), Vector3d(0, std::numbers::pi, 0),
                               Vector3d(0, 0, std::numbers::pi)}) {
    for (int i = 0; i < 20; ++i) {
      out = simulation.Step(state,
                            NeedleAt(t += 0.001, {0, 0, 40.0}, i < 10 ? turn : Vector3d(0, 0, 0)));
      SceneNeedleExpectSound(scene, state, out);
    }
    tip_mm.Add((out.shape.tip_in_ct_mm - before.shape.tip_in_ct_mm).norm());
    lateral_n.Add(out.force.lateral_n);
  }
  hard.Expect("tip when turned back", tip_mm, AtMost(0.05), "mm");
  hard.Expect("force across when turned back", lateral_n, AtMost(0.05), "N");
}

// A hand that presses with all its strength on bone: the axial force is the bone's, bounded; the
// needle leans with the hand but does not run away.
TEST(BendableHardCases, PressedOnBoneBeyondItsBucklingLoadItStaysBounded) {
  const HardCase hard("Pressed on bone with more than the load at which the needle buckles.");
  const Scene scene = SceneWith(NeedleForceModelKind::kLayered, nullptr);
  const Simulation simulation(scene);
  State state = simulation.NewState();
  double t = 0.0;
  StepOutput out;
  double largest_n = 0.0;
  for (double z = -2.0; z < 80.0; z += 0.05) {
    out = simulation.Step(state, NeedleAt(t += 0.001, {0, 20.0, z}, {0, 1e-4 * z, 0}));
    SceneNeedleExpectSound(scene, state, out);
    largest_n = std::max(largest_n, out.force.bone_n);
  }
  // Clamped at one end and guided at the other over what is outside, the needle buckles at this.
  const double free_mm = scene.needle->length_mm - 60.0;
  const double euler_n = 4.0 * std::numbers::pi * std::numbers::pi *
                         scene.needle->beam.BendingStiffnessNMm2() / (free_mm * free_mm);
  std::printf("  bone %.1f N, Euler %.1f N, deflection %.2f mm\n", largest_n, euler_n,
              out.shape.tip_deflection_mm);
  hard.Expect("force of the bone", largest_n, Above(5.0), "N");
  hard.Expect("deflection of the tip", out.shape.tip_deflection_mm, Below(5.0), "mm");
  hard.Expect("steps that did not converge", state.shape.needle.rod.num_not_converged, Exactly(0));
}

TEST(BendableHardCases, AStepAllocatesNothing) {
  const HardCase hard("Memory taken in a step of 1 ms can make it late.");
  for (const NeedleForceModelKind force : kSceneNeedleForces) {
    const Scene scene = SceneWith(force, nullptr);
    const Simulation simulation(scene);
    State state = simulation.NewState();
    math::Polyline line;
    StepOutput out;
    const long before = testing_support::num_allocations.load();
    for (int i = 0; i < 1500; ++i) {
      const double t = 1e-3 * i;
      out = simulation.Step(state, NeedleAt(t, {std::sin(t), 0, 50.0 * t - 5.0}, {0.1 * t, 0, t}));
      simulation.ShapeOf(state, line);
    }
    const long allocated = testing_support::num_allocations.load() - before;
    hard.Expect(Message("allocations in 1500 steps, ", SceneNeedleNameOf(force)), allocated,
                Exactly(0));
    EXPECT_TRUE(out.shape.bent);
  }
}

}  // namespace
}  // namespace acus::simulation
