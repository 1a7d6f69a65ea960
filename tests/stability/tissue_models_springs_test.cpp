// Hard cases of the springs, each with its bound.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/spring_model.h"
#include "references/closed_loop.h"
#include "support/bound.h"
#include "support/layered_tissue.h"
#include "support/stability_length.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::Layers;
using testing_support::ModelInsertion;

const Layers kTissueModelsSpringsBody{{{0, "skin"},
                                       {2, "fat"},
                                       {20, "liver"},
                                       {45, "vessel"},
                                       {47, "liver"},
                                       {90, "bone"},
                                       {110, "fat"}}};

SpringModel TissueModelsSpringsBody() {
  return SpringModel({}, testing_support::RoundForces(), testing_support::Trocar18(),
                     testing_support::RoundElasticity(), kTissueModelsSpringsBody.Tissues(),
                     kTissueModelsSpringsBody.At());
}

ToolSample TissueModelsSpringsWild(RandomStream& random, double& time_s) {
  ToolSample sample;
  time_s += random.Uniform() < 0.01 ? -0.5 : random.Uniform(1e-4, 1e-2);
  sample.time_s = random.Uniform() < 0.01 ? std::nan("") : time_s;
  sample.needle_valid = random.Uniform() > 0.02;
  sample.tip_in_ct_mm =
      Vector3d(random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-10, 120));
  if (random.Uniform() < 0.01) sample.tip_in_ct_mm.x() = std::nan("");
  if (random.Uniform() < 0.01) sample.tip_in_ct_mm *= 1e6;
  sample.axis_in_ct = Vector3d(random.Normal(), random.Normal(), 3.0);
  if (random.Uniform() < 0.01) sample.axis_in_ct.setZero();
  return sample;
}

TEST(TissueModelsSprings, RandomSamplesStayFiniteAndBounded) {
  const HardCase hard("Jumps, broken numbers, time that goes back, lost poses, at random.");
  Largest force_n;
  Largest moved_mm;
  const int num_steps = testing_support::StabilitySteps(200'000);
  const SpringModel model = TissueModelsSpringsBody();
  SpringState state = model.NewState();
  RandomStream random(1, "wild");
  TissueLoad load;
  SpringField field(model);
  double time_s = 0.0;
  for (int n = 0; n < num_steps; ++n) {
    const auto force = model.Step(state, TissueModelsSpringsWild(random, time_s));
    force_n.Add(force.force_in_ct_n.norm());
    ASSERT_LE(state.num_nodes, SpringState::kMaxNodes);
    if (n % 50 != 0) continue;
    model.LoadOf(state, load);
    field.Update(load);
    const Vector3d moved = field.DisplacementMm(Vector3d(1, 1, random.Uniform(-10, 100)));
    moved_mm.Add(moved.norm());
  }
  hard.Expect("largest force", force_n,
              AtMost(model.table().settings.largest_force_n * (1 + 1e-12)), "N");
  hard.Expect("largest displacement in the image", moved_mm, AtMost(12.0 * (1 + 1e-12)), "mm");
  hard.Note("wild steps", std::to_string(num_steps));
  EXPECT_GT(state.gate.num_rejected, 1000);
  EXPECT_GT(state.gate.num_time_back, 1000);
}

TEST(TissueModelsSprings, ACopyContinuesWithTheSameBits) {
  const HardCase hard("A state that is saved in the middle of wild samples goes on as the other.");
  int num_differ = 0;
  const SpringModel model = TissueModelsSpringsBody();
  SpringState state = model.NewState();
  RandomStream random(2, "wild");
  double time_s = 0.0;
  for (int n = 0; n < 500; ++n) model.Step(state, TissueModelsSpringsWild(random, time_s));
  SpringState copy = state;
  for (int n = 0; n < 5000; ++n) {
    const ToolSample sample = TissueModelsSpringsWild(random, time_s);
    const Vector3d a = model.Step(state, sample).force_in_ct_n;
    const Vector3d b = model.Step(copy, sample).force_in_ct_n;
    num_differ += std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0 ? 0 : 1;
  }
  hard.Expect("forces that differ in a bit, of 5000", num_differ, Exactly(0));
}

// 0.1 ms to 10 ms per step, and 50 mm in one.
TEST(TissueModelsSprings, TheForceDoesNotDependOnTheStep) {
  const HardCase hard("Steps of 0.1 to 10 ms, and 50 mm in one step.");
  const SpringModel model = TissueModelsSpringsBody();
  double force_n[4] = {};
  int i = 0;
  for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
    ModelInsertion<SpringModel> insertion{model};
    insertion.MoveToDepth(70.0, 20.0, dt_s);
    force_n[i++] = insertion.last.AxialN();
  }
  ModelInsertion<SpringModel> jumps{model};
  for (const double z : {-1.0, 20.0, 70.0, 70.0, 70.0}) jumps.StepTo(Vector3d(0, 0, z));
  hard.Expect("force at 0.1 ms against 1 ms", std::abs(force_n[0] - force_n[1]), AtMost(0.02), "N");
  hard.Expect("force at 10 ms against 1 ms", std::abs(force_n[2] - force_n[1]), AtMost(0.05), "N");
  // The friction of what a jump cut is not built up yet: the force is less, never more.
  hard.Expect("force after a jump of 50 mm beyond that of a slow way",
              jumps.last.AxialN() - force_n[1], AtMost(0.02), "N");
  hard.Expect("force after a jump of 50 mm", jumps.last.AxialN(), Above(0.5), "N");
}

// A force of exactly the threshold is enough, one bit less is not: 0.25 N/mm, 4 mm, 1 N.
TEST(TissueModelsSprings, PunctureExactlyAtTheThreshold) {
  const HardCase hard("A force of exactly the threshold is enough, one bit less is not.");
  forces::ForceTable table = testing_support::RoundForces();
  table.tissue[volume::LabelOf("skin")].membrane = {0.25, 0.0, 1.0};
  const SpringModel model({}, table, testing_support::Trocar18(),
                          testing_support::RoundElasticity(), kTissueModelsSpringsBody.Tissues(),
                          kTissueModelsSpringsBody.At());
  const auto event_at = [&](double depth_mm) {
    SpringState state = model.NewState();
    ToolSample sample;  // Starting on the skin: the path begins at 0 exactly.
    model.Step(state, sample);
    sample.time_s = 0.001;
    sample.tip_in_ct_mm.z() = depth_mm;
    return model.Step(state, sample).event;
  };
  hard.Expect("punctures at the threshold", event_at(4.0) == forces::NeedleEvent::kPuncture,
              Exactly(1));
  hard.Expect("punctures one bit before it",
              event_at(std::nextafter(4.0, 0.0)) == forces::NeedleEvent::kPuncture, Exactly(0));
}

TEST(TissueModelsSprings, StandingStillKeepsItsBits) {
  const HardCase hard(
      "A needle that stands still must feel nothing change, not even in the last bit.");
  Largest change_n;
  const SpringModel model = TissueModelsSpringsBody();
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(33.3);
  for (int n = 0; n < 50; ++n) insertion.StepTo(insertion.tip_mm);
  const Vector3d force = insertion.last.force_in_ct_n;
  for (int n = 0; n < 5000; ++n) {
    insertion.StepTo(insertion.tip_mm);
    change_n.Add((insertion.last.force_in_ct_n - force).norm());
  }
  hard.Expect("change of force in 5000 steps", change_n, Exactly(0), "N");
}

TEST(TissueModelsSprings, ALostNeedleKeepsItsForceAndLetsGoSlowly) {
  const SpringModel model = TissueModelsSpringsBody();
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(33.0);
  const Vector3d before = insertion.last.force_in_ct_n;
  ToolSample lost;
  lost.needle_valid = false;
  lost.time_s = insertion.time_s + 0.001;
  EXPECT_EQ(model.Step(insertion.state, lost).force_in_ct_n, before);
  lost.time_s = insertion.time_s + 100.0;
  EXPECT_EQ(model.Step(insertion.state, lost).force_in_ct_n.norm(), 0.0);
  EXPECT_GT(insertion.StepTo(insertion.tip_mm, 101.0).force_in_ct_n.norm(), 0.1);
}

TEST(TissueModelsSprings, GoesInAndOutAHundredTimes) {
  const HardCase hard("What is left of one insertion would add up over a hundred.");
  Largest drift_n;
  const SpringModel model = TissueModelsSpringsBody();
  ModelInsertion<SpringModel> insertion{model};
  double first_n = 0.0;
  for (int n = 0; n < 100; ++n) {
    insertion.MoveToDepth(40.0, 400.0);
    if (n == 0) first_n = insertion.last.AxialN();
    drift_n.Add(std::abs(insertion.last.AxialN() - first_n));
    insertion.MoveToDepth(-1.0, 400.0);
    EXPECT_EQ(insertion.state.num_nodes, 0);
  }
  hard.Expect("force at 40 mm against the first time", drift_n, AtMost(1e-6), "N");
  EXPECT_EQ(insertion.Count(forces::NeedleEvent::kWithdrawal), 100);
  hard.Expect("work of the hand", insertion.work_n_mm, Above(0.0), "mJ");
}

// Tissue that is held hardly farther out than the needle's surface is stiffer than any device can
// hold: the springs stay within what it can.
TEST(TissueModelsSprings, ASmallInfluenceRadiusDoesNotMakeADeviceOscillate) {
  const HardCase hard("Tissue held at 1 to 3 diameters: springs beyond what a device can hold.");
  // The first without that limit.
  for (const double radius_mm : {-1.28, 1.28, 1.5, 2.0, 4.0}) {
    const bool limited = radius_mm > 0.0;
    SpringSettings settings{.influence_radius_mm = std::abs(radius_mm)};
    if (!limited) settings.stiffest_across_n_per_mm = 1e9;
    const SpringModel model(settings, testing_support::RoundForces(), testing_support::Trocar18(),
                            testing_support::RoundElasticity(), kTissueModelsSpringsBody.Tissues(),
                            kTissueModelsSpringsBody.At());
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      SpringState state = model.NewState();
      forces::RandomHand motion{.across_mm = 3.0};
      motion.to_mm = 55.0;
      motion.slowest_s = 1.0;
      forces::Hand hand;
      hand.wants_in_ct_mm = forces::RandomMotion(motion, 10.0, seed);
      const forces::LoopResult result = forces::RunClosedLoop(
          {}, hand,
          [&](double t, const Vector3d& tip_mm) {
            return model.Step(state, {.time_s = t, .tip_in_ct_mm = tip_mm}).force_in_ct_n;
          },
          10.0);
      std::printf("  radius %.2f mm, hand %d: generated %.4f mJ, took %.1f mJ\n", radius_mm,
                  static_cast<int>(seed), result.generated_mj, result.taken_mj);
      const std::string of = Message(", radius ", radius_mm, " mm, hand ", seed);
      if (!limited) {
        EXPECT_GT(result.generated_mj, 1.0);
        continue;
      }
      hard.Expect("energy generated" + of, result.generated_mj, AtMost(1.0), "mJ");
      hard.Expect("energy taken" + of, result.taken_mj, Above(1.0), "mJ");
    }
  }
}

}  // namespace
}  // namespace acus::tissue
