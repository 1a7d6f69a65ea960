#include "acus/run/step/step_inputs.h"

#include <gtest/gtest.h>

#include "support/layered_scene.h"

namespace acus::step {
namespace {

using testing_support::LayeredScene;
using testing_support::PlanOf;

session::PoseSample At(double x_mm) {
  session::PoseSample sample;
  sample.reference_from_tool =
      transforms::Pose(Eigen::Isometry3d(Eigen::Translation3d(x_mm, 0.0, 0.0)));
  sample.valid = true;
  return sample;
}

TEST(StepInputs, AToolThatNoStageOfAStepReadsIsNotSeen) {
  const simulation::Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const StepInputs inputs(scene, {.needle = true, .probe = true});
  EXPECT_TRUE(inputs.steps());
  EXPECT_TRUE(inputs.reads_needle());
  EXPECT_FALSE(inputs.reads_probe());
  const simulation::Sample sample = inputs.SampleAt(7, At(1.0), At(2.0), {.cycle = 0.25}, 3.5);
  EXPECT_EQ(sample.time_ns, 7);
  EXPECT_TRUE(sample.needle_valid);
  EXPECT_EQ(sample.reference_from_needle.translation().x(), 1.0);
  EXPECT_FALSE(sample.probe_valid);
  EXPECT_TRUE(sample.reference_from_probe.isApprox(Eigen::Isometry3d::Identity(), 0.0));
  EXPECT_EQ(sample.breath.cycle, 0.25);
}

TEST(StepInputs, AToolThatTheSessionLacksIsNotSeen) {
  const simulation::Scene scene = LayeredScene(PlanOf(true, false, false, false), false);
  const StepInputs inputs(scene, {.needle = false, .probe = true});
  EXPECT_FALSE(inputs.SampleAt(0, At(1.0), At(2.0), {}, 0.0).needle_valid);
}

TEST(StepInputs, ASceneWithoutStagesOfAStepHasNothingToStep) {
  const StepInputs inputs(simulation::Scene{}, {.needle = true, .probe = true});
  EXPECT_FALSE(inputs.steps());
  EXPECT_FALSE(inputs.reads_needle());
  EXPECT_FALSE(inputs.reads_probe());
}

}  // namespace
}  // namespace acus::step
