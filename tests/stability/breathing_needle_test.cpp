// Hard cases of a needle and of images in a patient who breathes, each with a bound.
#include <cmath>
#include <gtest/gtest.h>

#include "acus/scene/simulation/probe_image_renderer.h"
#include "support/allocation_counter.h"
#include "support/bending_scene.h"
#include "support/bound.h"
#include "support/breathing_patients.h"

namespace acus::simulation {
namespace {

using breathing::MotionKind;
using Eigen::Vector3d;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BendingScene;
using testing_support::BoundPlot;
using testing_support::BreathingPatient;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::kAllMotionKinds;
using testing_support::Largest;
using testing_support::NeedleAt;

constexpr scenario::NeedleForceModelKind kForces[] = {scenario::NeedleForceModelKind::kLayered,
                                                      scenario::NeedleForceModelKind::kAlamilla,
                                                      scenario::NeedleForceModelKind::kTissue};

/// Around the block of BendingScene; moves across the needle and a little along it.
BreathingPatient Around(MotionKind kind, double largest_mm, double box_mm = 300.0) {
  BreathingPatient patient{.kind = kind, .nodes_per_axis = 32};
  patient.box.size.setConstant(301);
  patient.box.spacing_mm.setConstant(box_mm / 300.0);
  patient.box.origin_mm = Vector3d(-0.5, -0.5, -0.5) * box_mm + Vector3d(0.0, 0.0, 60.0);
  patient.largest_mm = largest_mm;
  patient.towards = {0.0, 1.0, 0.3};
  return patient;
}

const char* NameOf(scenario::NeedleForceModelKind force) {
  if (force == scenario::NeedleForceModelKind::kTissue) return "tissue";
  return force == scenario::NeedleForceModelKind::kAlamilla ? "alamilla" : "layered";
}

double LargestN(const Scene& scene) {
  return scene.force_from_tissue ? 30.0 : scene.forces->table().settings.largest_force_n;
}

void ExpectSound(const Scene& scene, const StepOutput& out) {
  ASSERT_TRUE(out.force.force_in_ct_n.allFinite());
  ASSERT_LE(out.force.force_in_ct_n.norm(), LargestN(scene) * (1.0 + 1e-12));
  ASSERT_TRUE(out.force.torque_in_ct_n_mm.allFinite());
  ASSERT_LT(out.force.torque_in_ct_n_mm.norm(), 5000.0);
  ASSERT_TRUE(std::isfinite(out.shape.tip_deflection_mm));
  ASSERT_LE(out.shape.tip_deflection_mm, scene.needle->length_mm);
}

/// In to 50 mm within a second of inspiration; then the hand holds still.
Vector3d InsertedMm(double t) {
  return {0.0, 0.0, std::min(50.0, -3.0 + 60.0 * t)};
}

struct Held {
  double largest_n = 0.0;
  double largest_step_n = 0.0;    ///< From one step to the next, once held.
  double breath_to_breath = 0.0;  ///< Largest difference of the third breath from the second, N.
};
Held HoldThreeBreaths(const Scene& scene, double period_s) {
  const Simulation simulation(scene);
  State state = simulation.NewState();
  const auto breath = static_cast<std::size_t>(std::lround(1e3 * period_s));
  std::vector<Vector3d> force_n;
  Held out;
  for (std::size_t n = 0; n < 4 * breath; ++n) {
    const double t = 1e-3 * static_cast<double>(n);
    const StepOutput step = simulation.Step(state, NeedleAt(t, InsertedMm(t)));
    ExpectSound(scene, step);
    force_n.push_back(step.force.force_in_ct_n);
    out.largest_n = std::max(out.largest_n, force_n.back().norm());
    if (n > breath) {
      out.largest_step_n = std::max(out.largest_step_n, (force_n[n] - force_n[n - 1]).norm());
    }
    if (n >= 3 * breath) {
      out.breath_to_breath =
          std::max(out.breath_to_breath, (force_n[n] - force_n[n - breath]).norm());
    }
  }
  return out;
}

// The hand holds still, the patient does not: 20 mm to and fro. Each breath feels like the one
// before; no step of the force is larger than what a cut or a stick can give.
TEST(BreathingNeedle, HeldByTheTissueItFeelsEachBreathAlike) {
  const HardCase hard(
      "The hand holds still, the patient moves by 20 mm: each breath as the one before.");
  for (const auto force : kForces) {
    for (const MotionKind kind : kAllMotionKinds) {
      BendingScene bending;
      bending.force = force;
      Scene scene = bending.Make();
      scene.breathing.emplace(Around(kind, 20.0).Make());
      const Held held = HoldThreeBreaths(scene, 4.0);
      std::printf("  force model %d, %-10s: to %.2f N, steps to %.3f N, breaths differ by %.3f N\n",
                  static_cast<int>(force), std::string(NameOf(kind)).c_str(), held.largest_n,
                  held.largest_step_n, held.breath_to_breath);
      const std::string of = Message(", ", NameOf(force), ", ", NameOf(kind));
      EXPECT_GT(held.largest_n, 0.3);
      hard.Expect("step of the force" + of, held.largest_step_n, Below(0.5), "N");
      hard.Expect("third breath against the second" + of, held.breath_to_breath, Below(0.1), "N");
    }
  }
}

// 120 mm over 200 folds the tissue around the needle: forces stay what the models allow, and after
// the fold the needle is felt as before.
TEST(BreathingNeedle, AFieldThatFoldsAroundItStaysBounded) {
  const HardCase hard("Tissue that folds over itself around the needle: 120 mm over 200.");
  for (const auto force : kForces) {
    BendingScene bending;
    bending.force = force;
    Scene scene = bending.Make();
    scene.breathing.emplace(Around(MotionKind::kFullCycle, 120.0, 200.0).Make());
    const Simulation simulation(scene);
    State state = simulation.NewState();
    Largest force_share;
    for (int n = 0; n < 12000; ++n) {
      const double t = 1e-3 * n;
      const StepOutput step = simulation.Step(state, NeedleAt(t, InsertedMm(t)));
      ExpectSound(scene, step);
      force_share.Add(step.force.force_in_ct_n.norm() / LargestN(scene));
      math::Polyline line;
      if (!simulation.ShapeOf(state, line)) continue;
      for (int i = 0; i < line.num_points; ++i) ASSERT_TRUE(line.At(i).allFinite());
    }
    // Out again, in air: nothing is felt.
    StepOutput out;
    for (int n = 12000; n < 13000; ++n) {
      out = simulation.Step(state, NeedleAt(1e-3 * n, {0.0, 0.0, -150.0}));
    }
    hard.Expect(Message("largest force, of its limit, ", NameOf(force)), force_share,
                AtMost(1.0 + 1e-12));
    hard.Expect(Message("force when out again, ", NameOf(force)), out.force.force_in_ct_n.norm(),
                Below(1e-6), "N");
  }
}

/// Tissue beyond z = 30 mm slides sideways by up to 20 mm, that before it does not: one cell of
/// 5 mm between.
Breathing SlidingLayers() {
  BreathingPatient patient = Around(MotionKind::kSinusoid, 20.0);
  Breathing out = patient.Make();
  volume::Geometry nodes;
  nodes.size = {5, 5, 61};
  nodes.spacing_mm = {75.0, 75.0, 5.0};
  nodes.origin_mm = {-150.0, -150.0, -122.5};
  breathing::MotionField field(nodes, 1);
  std::vector<float> values;
  for (int k = 0; k < 61; ++k) {
    for (int n = 0; n < 25; ++n) {
      values.insert(values.end(), {0.0F, -122.5 + 5.0 * k > 30.0 ? 20.0F : 0.0F, 0.0F});
    }
  }
  field.SetComponent(0, values);
  out.motion.model = breathing::MotionModel::Sinusoid(std::move(field), 1.0);
  return out;
}

// A needle across the liver's capsule and the ribs' inside: bent by one cell of shear 4.
TEST(BreathingNeedle, ThroughASlidingInterfaceItStaysBoundedAndWhole) {
  const HardCase hard("Through an interface that slides by 20 mm: bent by one cell of shear 4.");
  for (const auto force : kForces) {
    BendingScene bending;
    bending.force = force;
    Scene scene = bending.Make();
    scene.breathing.emplace(SlidingLayers());
    const Simulation simulation(scene);
    State state = simulation.NewState();
    Largest longest_mm;
    Largest most_bent_mm;
    for (int n = 0; n < 9000; ++n) {
      const double t = 1e-3 * n;
      const StepOutput step = simulation.Step(state, NeedleAt(t, InsertedMm(t)));
      ExpectSound(scene, step);
      most_bent_mm.Add(step.shape.tip_deflection_mm);
      math::Polyline line;
      if (!simulation.ShapeOf(state, line)) continue;
      double length_mm = 0.0;
      for (int i = 1; i < line.num_points; ++i) length_mm += (line.At(i) - line.At(i - 1)).norm();
      longest_mm.Add(length_mm);
    }
    hard.Expect(Message("length of the needle, ", NameOf(force)), longest_mm,
                AtMost(scene.needle->length_mm + 1e-6), "mm");
    hard.Expect(Message("deflection of the tip, at least, ", NameOf(force)), most_bent_mm,
                Above(1.0), "mm");
  }
}

// A minute of held breath after the needle went in: what is felt creeps by no more than the 0.3 mJ
// a minute allow that a bent needle gives back of what the hand has not put in.
TEST(BreathingNeedle, HeldBreathHoldsTheForceStill) {
  const HardCase hard("A minute of held breath: what is felt must not creep.");
  BoundPlot plot{.title = "Force on a needle that is held, breath held from 2 s on",
                 .x_label = "time [s]",
                 .y_label = "force [N]",
                 .curves = {{}}};
  Scene scene = BendingScene{}.Make();
  scene.breathing.emplace(Around(MotionKind::kSurrogate, 20.0).Make());
  scene.breathing->source = breathing::BreathSource(
      breathing::BreathingPattern({.period_s = 4.0, .exponent = 1}), {{2.0, 65.0}});
  const Simulation simulation(scene);
  State state = simulation.NewState();
  Vector3d at_rest_n = Vector3d::Zero();
  Largest largest_drift_n;
  for (int n = 0; n < 64000; ++n) {
    const double t = 1e-3 * n;
    const StepOutput step = simulation.Step(state, NeedleAt(t, InsertedMm(t)));
    if (n == 5000) at_rest_n = step.force.force_in_ct_n;
    if (n > 5000) {
      largest_drift_n.Add((step.force.force_in_ct_n - at_rest_n).norm());
    }
    if (n % 100 == 0) plot.curves[0].Add(t, step.force.force_in_ct_n.norm());
  }
  EXPECT_GT(at_rest_n.norm(), 0.1);
  hard.Expect("drift in a minute, of 2.8 N", largest_drift_n, Below(0.05), "N");
  hard.Plot(plot);
}

TEST(BreathingNeedle, JumpsTimeAndInvalidDataOfTheHandStayBounded) {
  const HardCase hard(
      "Jumps, time that goes back and an hour ahead, NaN, while the patient breathes.");
  Largest force_share;
  for (const MotionKind kind : kAllMotionKinds) {
    Scene scene = BendingScene{}.Make();
    scene.breathing.emplace(Around(kind, 30.0).Make());
    const Simulation simulation(scene);
    State state = simulation.NewState(0);
    for (int n = 0; n < 4000; ++n) {
      const double t = 1e-3 * n;
      Sample sample = NeedleAt(t, InsertedMm(t));
      if (n % 100 == 37) sample.reference_from_needle.translation() += Vector3d(50.0, 0.0, 0.0);
      if (n % 100 == 51) sample.reference_from_needle.translation().setConstant(std::nan(""));
      if (n % 100 == 62) sample.time_ns -= 500'000'000;
      if (n % 100 == 73) sample.needle_valid = false;
      if (n == 3000) sample.time_ns += 3'600'000'000'000;
      const StepOutput step = simulation.Step(state, sample);
      ExpectSound(scene, step);
      force_share.Add(step.force.force_in_ct_n.norm() / LargestN(scene));
    }
  }
  hard.Expect("largest force, of its limit", force_share, AtMost(1.0 + 1e-12));
}

TEST(BreathingNeedle, AStepAllocatesNothing) {
  const HardCase hard("Memory taken in a step of 1 ms can make it late.");
  Scene scene = BendingScene{}.Make();
  scene.breathing.emplace(Around(MotionKind::kSurrogate, 20.0).Make());
  const Simulation simulation(scene);
  State state = simulation.NewState();
  const long before = testing_support::num_allocations;
  for (int n = 0; n < 3000; ++n) {
    simulation.Step(state, NeedleAt(1e-3 * n, InsertedMm(1e-3 * n)));
  }
  const long allocated = testing_support::num_allocations - before;
  hard.Expect("allocations in 3000 steps", allocated, Exactly(0));
}

// Images of fields that fold: finite, the same bits again, no more than five iterations a knot.
TEST(BreathingImages, AFoldingFieldGivesAnImageAndTheSameAgain) {
  const HardCase hard("An image of a field that folds, and the same again after another one.");
  Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
  for (const double largest_mm : {60.0, 150.0}) {
    scene.breathing.emplace(Around(MotionKind::kFullCycle, largest_mm, 120.0).Make());
    Snapshot snapshot{.session_s = 2.0, .probe_valid = true};
    snapshot.ct_from_probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    ProbeImages first, second;
    ProbeImageRenderer renderer(scene);
    renderer.Render(snapshot, first);
    snapshot.session_s = 0.7;
    renderer.Render(snapshot, second);
    EXPECT_NE(first.b_mode.pixels, second.b_mode.pixels);
    snapshot.session_s = 2.0;
    renderer.Render(snapshot, second);
    const bool same = first.b_mode.pixels == second.b_mode.pixels &&
                      first.ct_slice.pixels == second.ct_slice.pixels;
    hard.Expect(Message("same images of one moment, field of ", largest_mm, " mm over 120"), same,
                Exactly(1));
  }
}

}  // namespace
}  // namespace acus::simulation
