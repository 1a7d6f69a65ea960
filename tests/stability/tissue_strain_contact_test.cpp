// Contact with tissue that stiffens, driven hard: forces stay bounded and settle, and no energy
// comes out of the tissue.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/random.h"
#include "support/bound.h"
#include "support/fem_needle_scene.h"
#include "support/stability_length.h"

namespace acus::tissue {
namespace {

using forces::NeedleForce;
using testing_support::Above;
using testing_support::AtLeast;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::FemScene;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::SceneOptions;

SceneOptions Stiffening(double exponent_b, double inner_mpa = 0.05) {
  SceneOptions options;
  options.inner_below_mm = 30.0;
  options.inner_mpa = inner_mpa;
  options.reach_mm = 25.0;
  options.law = {mechanics::LawKind::kFung, 0.0, 0.0, exponent_b};
  options.contact.strain.emplace();
  options.contact.strain->element = mechanics::ElementKind::kLinear;
  options.contact.strain->corridor = {{0, 0, 65}, {0, 0, 10}, 12.0};
  return options;
}

TEST(StrainContactStability, AJumpOf50MmIsBoundedAndForgotten) {
  const HardCase hard("The tracker jumps by 50 mm and more in a step, in tissue that stiffens.");
  FemScene steady(Stiffening(5.0));
  FemScene jumping(Stiffening(5.0));
  steady.Move(-1.0, 25.0);
  jumping.StepAt(-25.0);
  for (int n = 0; n < 100; ++n) jumping.StepAt(25.0);
  for (int n = 0; n < 100; ++n) steady.StepAt(25.0);
  hard.Expect("cutting force against that of a slow way",
              std::abs(jumping.StepAt(25.0).cutting_n - steady.StepAt(25.0).cutting_n), AtMost(0.1),
              "N");
  hard.Expect("displacements out 0.1 s after the jump", jumping.state.strain.error_mm, AtMost(1e-3),
              "mm");
  Largest any_n;
  for (const double depth_mm : {-25.0, 75.0, 25.0, -25.0, 25.0}) {
    for (int n = 0; n < 3; ++n) any_n.Add(jumping.StepAt(depth_mm).force_in_ct_n.norm());
  }
  hard.Expect("largest force over jumps of up to 100 mm", any_n, AtMost(30.0 + 1e-9), "N");
}

TEST(StrainContactStability, RandomHandlingStaysBounded) {
  const HardCase hard(
      "In, out, aside and tilted at random, jumping, with exponents of 2 to 40 and one tissue 1000 "
      "times as stiff as the other.");
  const int num_steps = testing_support::StabilitySteps(4000);
  for (const double exponent_b : {2.0, 10.0, 40.0}) {
    FemScene scene(Stiffening(exponent_b, exponent_b > 5.0 ? 20.0 : 0.05));
    RandomStream random(31, "strain handling");
    double depth_mm = -5.0, x_mm = 0.3, tilt = 0.0;
    Largest force_n;
    bool finite = true;
    for (int step = 0; step < num_steps; ++step) {
      const double kind = random.Uniform();
      depth_mm += kind < 0.95 ? random.Uniform(-1.0, 1.05) : random.Uniform(-10.0, 10.0);
      depth_mm = std::clamp(depth_mm, -10.0, 50.0);
      x_mm = 0.99 * x_mm + random.Uniform(-0.1, 0.1);
      tilt = std::clamp(tilt + random.Uniform(-0.02, 0.02), -0.4, 0.4);
      const NeedleForce force = scene.StepAt(depth_mm, x_mm, -0.7, tilt);
      force_n.Add(force.force_in_ct_n.norm());
      finite = finite && force.force_in_ct_n.allFinite() && force.torque_in_ct_n_mm.allFinite();
    }
    EXPECT_TRUE(finite) << exponent_b;
    hard.Expect(Message("largest force, exponent ", exponent_b), force_n, AtMost(30.0 + 1e-9), "N");
    // A hand that then draws the needle out slowly and comes again finds tissue as ever.
    scene.Move(depth_mm, -10.0, 0.5);
    FemScene fresh(Stiffening(exponent_b, exponent_b > 5.0 ? 20.0 : 0.05));
    fresh.StepAt(-10.0, 9.0, 8.0);
    scene.StepAt(-10.0, 9.0, 8.0);
    NeedleForce a, b;
    for (double d = -10.0; d < 2.0; d += 0.05) {
      a = scene.StepAt(d, 9.0, 8.0);
      b = fresh.StepAt(d, 9.0, 8.0);
    }
    EXPECT_GT(b.force_in_ct_n.norm(), 0.05);
    hard.Expect(Message("skin afterwards against fresh skin, exponent ", exponent_b),
                (a.force_in_ct_n - b.force_in_ct_n).norm(), AtMost(1e-3), "N");
  }
}

TEST(StrainContactStability, NoEnergyComesOutOfTheTissue) {
  const HardCase hard("A hand that moves to and fro in the channel must not be driven by it.");
  FemScene scene(Stiffening(8.0));
  scene.Move(-1.0, 25.0);
  scene.Move(25.0, 15.0);
  double work_n_mm = 0.0, least_n_mm = 0.0, last_depth_mm = 15.0;
  for (const double mm : {0.05, 0.5, 2.0, 5.0}) {
    const double start_n_mm = work_n_mm;
    for (int step = 1; step <= 1600; ++step) {
      const double depth_mm = 15.0 + mm * std::sin(2.0 * std::numbers::pi * step / 400.0);
      work_n_mm += scene.StepAt(depth_mm).AxialN() * (depth_mm - last_depth_mm);
      least_n_mm = std::min(least_n_mm, work_n_mm);
      last_depth_mm = depth_mm;
    }
    hard.Expect(Message("work of the hand in four cycles of ", mm, " mm"), work_n_mm - start_n_mm,
                AtLeast(-1e-6), "mJ");
  }
  hard.Expect("least work until any moment", least_n_mm, Above(-0.6), "mJ");
}

TEST(StrainContactStability, PressedSkinGivesBackNoMoreThanItTook) {
  const HardCase hard("Skin is pressed and let go at 5 to 500 mm/s; it has no friction.");
  for (const double speed_mm : {0.005, 0.05, 0.5}) {
    FemScene scene(Stiffening(8.0));
    scene.Move(-2.0, 0.1, speed_mm);
    double work_n_mm = 0.0, last_mm = 0.1, stored_n_mm = 0.0;
    const int steps = static_cast<int>(2.0 / speed_mm);
    double last_n = scene.StepAt(0.1).AxialN();
    for (int n = 1; n <= 8 * steps; ++n) {
      const double depth_mm = 1.1 - 1.0 * std::cos(std::numbers::pi * n / steps);
      const double now_n = scene.StepAt(depth_mm).AxialN();
      work_n_mm += 0.5 * (now_n + last_n) * (depth_mm - last_mm);
      last_n = now_n;
      last_mm = depth_mm;
      stored_n_mm = std::max(stored_n_mm, work_n_mm);
    }
    EXPECT_EQ(scene.state.phase, NeedlePhase::kOnSkin);
    EXPECT_GT(stored_n_mm, 0.2);
    hard.Expect(Message("work that four cycles took, as a share of what was stored, ",
                        1e3 * speed_mm, " mm/s"),
                work_n_mm / stored_n_mm, AtLeast(-0.01), "");
  }
}

TEST(StrainContactStability, StandingStillChangesNothing) {
  const HardCase hard("A needle that stands still in tissue that stiffens must feel no change.");
  FemScene scene(Stiffening(8.0));
  scene.Move(-1.0, 33.0);
  for (int n = 0; n < 500; ++n) scene.StepAt(33.0, 0.3, -0.7, 0.1);
  const Eigen::Vector3d rest = scene.StepAt(33.0, 0.3, -0.7, 0.1).force_in_ct_n;
  Largest change_n;
  for (int n = 0; n < 1000; ++n) {
    change_n.Add((scene.StepAt(33.0, 0.3, -0.7, 0.1).force_in_ct_n - rest).norm());
  }
  hard.Expect("change of force in 1 s, from 0.5 s on", change_n, Below(1e-9), "N");
}

}  // namespace
}  // namespace acus::tissue
