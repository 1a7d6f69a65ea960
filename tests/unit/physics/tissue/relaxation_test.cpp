// Held tissue relaxes: the 3D contact model against the closed forms of a Prony series.
#include <cmath>
#include <gtest/gtest.h>

#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using testing_support::FemScene;
using testing_support::SceneOptions;

mechanics::Relaxation TwoTerms() {
  mechanics::Relaxation out;
  out.term[0] = {0.3, 0.05};
  out.term[1] = {0.25, 1.0};
  out.num_terms = 2;
  return out;
}

SceneOptions Relaxing() {
  SceneOptions options;
  options.relaxation = TwoTerms();
  return options;
}

/// The place of contact is found to 1e-6 of the way into the skin, and so the force.
constexpr double kCrossing = 2e-6;

double ShareAfter(double seconds) {
  double share = 1.0;
  for (const auto& term : {TwoTerms().term[0], TwoTerms().term[1]}) {
    share -= term.share * (1.0 - std::exp(-seconds / term.time_s));
  }
  return share;
}

TEST(Relaxation, TheForceOfAHeldTipFallsByTheSeries) {
  FemScene elastic, relaxing(Relaxing());
  elastic.StepAt(-1.0);
  relaxing.StepAt(-1.0);
  const double whole_n = elastic.StepAt(2.0).puncture_n;
  ASSERT_GT(whole_n, 0.3);
  for (int n = 1; n <= 3000; ++n) {
    EXPECT_NEAR(relaxing.StepAt(2.0).puncture_n, whole_n * ShareAfter(1e-3 * n), kCrossing) << n;
  }
}

TEST(Relaxation, StepsOfAnyLengthGiveTheSameHold) {
  for (const double step_s : {1e-4, 2e-3, 0.05}) {
    FemScene elastic, scene(Relaxing());
    scene.step_s = step_s;
    scene.StepAt(-1.0);
    elastic.StepAt(-1.0);
    const double whole_n = elastic.StepAt(2.0).puncture_n;
    double force_n = 0.0;
    const int steps = static_cast<int>(std::lround(1.0 / step_s));
    for (int n = 0; n < steps; ++n) force_n = scene.StepAt(2.0).puncture_n;
    EXPECT_NEAR(force_n, whole_n * ShareAfter(1.0), kCrossing) << step_s;
  }
}

TEST(Relaxation, PressedTissueComesBackLateAndWholly) {
  FemScene scene(Relaxing());
  scene.StepAt(-1.0);
  double held_n = 0.0;
  for (int n = 0; n < 5000; ++n) held_n = scene.StepAt(3.0).puncture_n;
  // Drawn back to where elastic tissue would still press: it has not come back yet.
  EXPECT_EQ(scene.StepAt(1.2).puncture_n, 0.0);
  double back_n = 0.0;
  for (int n = 0; n < 8000; ++n) back_n = scene.StepAt(1.2).puncture_n;
  EXPECT_GT(back_n, 0.0);
  FemScene fresh(Relaxing());
  fresh.StepAt(-1.0);
  double fresh_n = 0.0;
  for (int n = 0; n < 8000; ++n) fresh_n = fresh.StepAt(1.2).puncture_n;
  EXPECT_NEAR(back_n, fresh_n, 0.01 * fresh_n);
  EXPECT_LT(held_n, 3.0 / 1.2 * fresh_n * 1.2);
}

TEST(Relaxation, SlowHandsPressDeeperBeforeThePuncture) {
  const auto depth_of_puncture = [](double mm_per_step) {
    FemScene scene(Relaxing());
    for (double depth_mm = -0.5; depth_mm < 40.0; depth_mm += mm_per_step) {
      if (scene.StepAt(depth_mm).event == forces::NeedleEvent::kPuncture) return depth_mm;
    }
    return 40.0;
  };
  const double fast_mm = depth_of_puncture(0.5), slow_mm = depth_of_puncture(0.002);
  EXPECT_GT(slow_mm, 1.3 * fast_mm);
  EXPECT_LT(slow_mm, fast_mm / ShareAfter(1e9) * 1.05);
}

TEST(Relaxation, ClosedLoopsTakeWork) {
  for (const double amplitude_mm : {0.2, 1.0, 4.0}) {
    FemScene scene(Relaxing());
    scene.Move(-1.0, 20.0);
    double work_n_mm = 0.0, before_mm = 20.0;
    // What the insertion has stored may come back at first: eight cycles, then five to measure.
    constexpr double kCycle = 2.0 * 3.14159265358979 / 0.02;
    for (int n = 0; n < 13.0 * kCycle; ++n) {
      const double depth_mm = 20.0 - amplitude_mm * (1.0 - std::cos(0.02 * n));
      const double force_n = -scene.StepAt(depth_mm).force_in_ct_n.dot(Eigen::Vector3d(0, 0, -1));
      if (n > 8.0 * kCycle) work_n_mm += force_n * (depth_mm - before_mm);
      before_mm = depth_mm;
    }
    EXPECT_GT(work_n_mm, 0.0) << amplitude_mm;
  }
}

TEST(Relaxation, AHeldShaftLosesFrictionToo) {
  FemScene scene(Relaxing());
  scene.Move(-1.0, 25.0);
  const double moving_n = scene.StepAt(25.0).friction_n;
  double held_n = 0.0;
  for (int n = 0; n < 6000; ++n) held_n = scene.StepAt(25.0).friction_n;
  EXPECT_GT(moving_n, 0.3);
  EXPECT_LT(held_n, 0.75 * moving_n);
  EXPECT_GT(held_n, 0.2 * moving_n);
}

TEST(Relaxation, ALostForceIsNotBroughtToANewContact) {
  FemScene scene(Relaxing());
  scene.Move(-1.0, 25.0);
  for (int n = 0; n < 500; ++n) scene.StepAt(25.0);
  scene.Move(25.0, -3.0);
  EXPECT_EQ(scene.state.phase, NeedlePhase::kFree);
  FemScene fresh(Relaxing());
  fresh.StepAt(-3.0);
  // At another place of the skin.
  scene.StepAt(-3.0, 8.0, 8.0);
  fresh.StepAt(-3.0, 8.0, 8.0);
  EXPECT_NEAR(scene.StepAt(1.0, 8.0, 8.0).puncture_n, fresh.StepAt(1.0, 8.0, 8.0).puncture_n,
              kCrossing);
}

}  // namespace
}  // namespace acus::tissue
