// One scenario through everything that a hand and a tracker can do to it: nothing that is no
// number, no force over its limit, no energy from nowhere.
#pragma once

#include <cmath>
#include <functional>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/physics/breathing/breath_source.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"
#include "references/closed_loop.h"
#include "support/wild_hand.h"

namespace acus::testing_support {

class Violation : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline void Require(bool holds, const std::string& what) {
  if (!holds) throw Violation(what);
}

/// What was done to a scenario up to the moment, plain memory: it can be shared with the process
/// that waits for a child, which may crash.
struct TrialTrace {
  static constexpr int kMostSteps = 8000;
  struct Place {
    std::int64_t time_ns;
    double tip_mm[3];
    double axis[3];
    bool valid;
  };

  int phase = 0;  ///< Of ScenarioTrial::Phase.
  int num_steps = 0;
  double largest_force_share = 0.0;  ///< Of the limit, over all phases.
  double generated_mj = 0.0;         ///< Most energy given to a hand that goes its way.
  double strained_mj = 0.0;          ///< The same in held breath.
  double loop_mj = 0.0;              ///< Most energy given to a device and a hand of springs.
  Place place[kMostSteps] = {};
};

/// The probe lies on the skin and moves a little.
inline Eigen::Isometry3d ProbeOnSkin(double t) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  pose.translation() << 2.0 * std::sin(t), 3.0, std::sin(2.0 * t);
  return pose;
}

/// Runs all phases of one scenario. The same seed gives the same samples.
class ScenarioTrial {
 public:
  enum Phase { kNone, kHand, kHeldBreath, kLoop, kWild };
  static const char* NameOf(int phase) {
    constexpr const char* kNames[] = {"before the first step", "a hand at random",
                                      "a hand at random, breath held", "a device and a hand",
                                      "a wild hand and a broken tracker"};
    return kNames[phase];
  }
  using StepCheck = std::function<void(const simulation::StepOutput& out)>;

  static constexpr double kEnergyLimitMj = 0.1;  // In four seconds; 1 mJ a minute is what is felt.
  static constexpr double kLoopLimitMj = 1.0;  // With encoder and delay, as in forces_stability.md.
  static constexpr int kHandSteps = 4000;
  static constexpr int kWildSteps = 1500;
  static constexpr double kHeldFromS = 1.0;  // All have breathed a little by then.

  /// @param trace  What is done is written there. @param also  is called after each step.
  ScenarioTrial(simulation::Scene scene, TrialTrace& trace, StepCheck also = {})
      : scene_(std::move(scene)), trace_(trace), also_(std::move(also)) {}

  /// @throws Violation
  void Run(std::uint64_t seed) {
    Felt(seed, kHand);
    if (scene_.breathing) {
      const breathing::BreathSource free = scene_.breathing->source;
      scene_.breathing->source = breathing::BreathSource(free.signal(), {{kHeldFromS, 1e6}});
      Felt(seed, kHeldBreath);
      scene_.breathing->source = free;
    } else {
      InTheLoop(seed);
    }
    Wild(seed);
  }

 private:
  simulation::StepOutput Step(const simulation::Simulation& simulation, simulation::State& state,
                              const simulation::Sample& sample) {
    if (trace_.num_steps < TrialTrace::kMostSteps) {
      TrialTrace::Place& place = trace_.place[trace_.num_steps++];
      place.time_ns = sample.time_ns;
      for (int i = 0; i < 3; ++i) {
        place.tip_mm[i] = sample.reference_from_needle.translation()[i];
        place.axis[i] = sample.reference_from_needle.linear()(i, 2);
      }
      place.valid = sample.needle_valid;
    }
    const simulation::StepOutput out = simulation.Step(state, sample);
    Check(simulation, state, out);
    if (also_) also_(out);
    return out;
  }

  void Begin(Phase phase) {
    trace_.phase = phase;
    trace_.num_steps = 0;
  }

  void Check(const simulation::Simulation& simulation, const simulation::State& state,
             const simulation::StepOutput& out) {
    const double most_n = scene_.force_from_tissue || !scene_.forces
                              ? 30.0
                              : scene_.forces->table().settings.largest_force_n;
    const double force_n = PassiveForceN(out).norm();  // That of a thumb has its own limit.
    Require(out.force.force_in_ct_n.allFinite(), "force is not finite");
    trace_.largest_force_share = std::max(trace_.largest_force_share, force_n / most_n);
    Require(force_n <= most_n * (1.0 + 1e-9), Message("force of ", force_n, " N is over ", most_n));
    Require(std::isfinite(out.force.AxialN()), "axial force is not finite");
    Require(out.force.torque_in_ct_n_mm.allFinite(), "torque is not finite");
    Require(out.force.torque_in_ct_n_mm.norm() < 1e5, "torque is beyond all measure");
    Require(out.probe.force_in_ct_n.allFinite(), "probe force is not finite");
    Require(out.probe.force_in_ct_n.norm() <= 100.0, "probe force is over 100 N");
    Require(std::isfinite(out.shape.tip_deflection_mm), "deflection is not finite");
    math::Polyline line;
    if (!simulation.ShapeOf(state, line)) return;
    for (int i = 0; i < line.num_points; ++i) {
      Require(line.At(i).allFinite(), "shape is not finite");
    }
  }

  void Look(const simulation::Simulation& simulation, const simulation::State& state,
            const simulation::StepOutput& out, double t) const {
    simulation::Snapshot snapshot{.time_ns = out.time_ns, .session_s = t};
    snapshot.probe_valid = true;
    snapshot.ct_from_probe = ProbeOnSkin(t);
    snapshot.ct_from_needle = out.ct_from_needle;
    math::Polyline line;
    if (simulation.ShapeOf(state, line)) snapshot.needle_shape = &line;
    tissue::TissueLoad load;
    if (scene_.plan.Writes(effects::ports::kRestMap) && simulation.LoadOf(state, out, load)) {
      snapshot.load = &load;
    }
    simulation::ProbeImageRenderer renderer(scene_);
    simulation::ProbeImages images;
    simulation::ProbeImages again;
    renderer.Render(snapshot, images);
    renderer.Render(snapshot, again);
    Require(images.b_mode.pixels == again.b_mode.pixels, "two B-modes of one moment differ");
    Require(images.ct_slice.pixels == again.ct_slice.pixels, "two slices of one moment differ");
  }

  static void RequirePassive(double generated_mj, double most_mj, double& largest_mj) {
    largest_mj = std::max(largest_mj, generated_mj);
    Require(generated_mj <= most_mj, Message("gave ", generated_mj, " mJ, over ", most_mj));
  }

  /// What the needle's hand feels without effects that press by themselves, such as a thumb on the
  /// plunger, which does work as a person does.
  static Eigen::Vector3d PassiveForceN(const simulation::StepOutput& out) {
    return out.force.force_in_ct_n - out.added_in_ct_n;
  }

  /// A hand in and out of the tissue: sound, and since it was last free it gets no energy. The
  /// force goes from one sample's to the next's; what holding it for a step adds is the sampling's,
  /// which the device has to take, and is judged in the loop.
  void Felt(std::uint64_t seed, Phase phase) {
    Begin(phase);
    const simulation::Simulation simulation(scene_);
    simulation::State state = simulation.NewState();
    forces::RandomHand hand{.across_mm = 3.0};
    hand.to_mm = 58.0;
    hand.slowest_s = 1.0;
    const auto place = forces::RandomMotion(hand, 1e-3 * kHandSteps, seed);
    const double begin_s = phase == kHeldBreath ? kHeldFromS + 0.5 : 0.0;
    const int begin = static_cast<int>(std::lround(1e3 * begin_s));
    double balance_mj = 0.0;
    double generated_mj = 0.0;
    simulation::StepOutput before;
    for (int i = 0; i < begin + kHandSteps; ++i) {
      const double t = 1e-3 * i;
      simulation::Sample sample{.time_ns = std::llround(1e9 * t), .needle_valid = true};
      sample.reference_from_needle.translation() = place(std::max(0.0, t - begin_s));
      if (i < begin) sample.reference_from_needle.translation().z() = -60.0;
      sample.probe_valid = true;
      sample.reference_from_probe = ProbeOnSkin(t);
      const simulation::StepOutput out = Step(simulation, state, sample);
      const Eigen::Vector3d mean_n = 0.5 * (PassiveForceN(before) + PassiveForceN(out));
      const Eigen::Vector3d moved_mm =
          out.ct_from_needle.translation() - before.ct_from_needle.translation();
      balance_mj -= mean_n.dot(moved_mm);
      generated_mj = std::max(generated_mj, -balance_mj);
      if (out.force.force_in_ct_n.isZero() && out.force.torque_in_ct_n_mm.isZero()) {
        balance_mj = 0.0;
      }
      before = out;
      if (i == begin + 1500 || i == begin + kHandSteps - 1) Look(simulation, state, out, t);
    }
    // A patient who breathes or moves does work on the needle.
    if (scene_.listed.moves_tissue()) return;
    if (phase == kHeldBreath) {
      RequirePassive(generated_mj, kEnergyLimitMj, trace_.strained_mj);
    } else if (!scene_.breathing) {
      RequirePassive(generated_mj, kEnergyLimitMj, trace_.generated_mj);
    }
  }

  /// A device of 100 g and a hand of springs: the force comes late, and drives what it may not.
  void InTheLoop(std::uint64_t seed) {
    Begin(kLoop);
    const simulation::Simulation simulation(scene_);
    simulation::State state = simulation.NewState();
    forces::RandomHand motion{.across_mm = 3.0};
    motion.to_mm = 55.0;
    motion.slowest_s = 1.0;
    forces::Hand hand;
    hand.wants_in_ct_mm = forces::RandomMotion(motion, 3.0, seed + 1'000'000);
    const forces::LoopResult result = forces::RunClosedLoop(
        {}, hand,
        [&](double t, const Eigen::Vector3d& tip_mm) -> Eigen::Vector3d {
          simulation::Sample sample{.time_ns = std::llround(1e9 * t), .needle_valid = true};
          sample.reference_from_needle.translation() = tip_mm;
          sample.probe_valid = true;
          sample.reference_from_probe = ProbeOnSkin(t);
          return Step(simulation, state, sample).force.force_in_ct_n;
        },
        3.0);
    // A thumb on the plunger does work on the device, and so does a patient who moves;
    // fluid_closed_loop_test has the fluid alone.
    if (!scene_.listed.adds_force() && !scene_.listed.moves_tissue()) {
      RequirePassive(result.generated_mj, kLoopLimitMj, trace_.loop_mj);
    }
  }

  /// Jumps, lost poses, numbers that are none.
  void Wild(std::uint64_t seed) {
    Begin(kWild);
    const simulation::Simulation simulation(scene_);
    simulation::State state = simulation.NewState();
    WildHand hand(seed);
    for (int i = 0; i < kWildSteps; ++i) {
      const forces::NeedleInput input = hand.Next();
      simulation::Sample sample{.needle_valid = input.valid};
      sample.time_ns = std::isfinite(input.time_s) && std::abs(input.time_s) < 1e9
                           ? std::llround(1e9 * input.time_s)
                           : std::numeric_limits<std::int64_t>::min();
      sample.reference_from_needle.linear().col(2) = input.axis_in_ct;
      sample.reference_from_needle.translation() = input.tip_in_ct_mm;
      sample.probe_valid = i % 7 != 0;
      sample.reference_from_probe = ProbeOnSkin(0.01 * i);
      if (i % 100 == 0) sample.reference_from_probe.translation() = input.tip_in_ct_mm;
      Step(simulation, state, sample);
    }
  }

  simulation::Scene scene_;
  TrialTrace& trace_;
  StepCheck also_;
};

}  // namespace acus::testing_support
