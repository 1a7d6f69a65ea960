#include "acus/run/replay/motion_bound_metrics.h"

#include <gmock/gmock.h>

namespace acus::replay {
namespace {

/// A body whose bound is x / 10 mm at full inspiration, held there.
simulation::Breathing BoundedBreathing(double amplitude) {
  volume::Geometry nodes;
  nodes.size = {11, 2, 2};
  nodes.spacing_mm = {10.0, 100.0, 100.0};
  std::vector<float> mm;
  for (std::size_t n = 0; n < nodes.num_voxels(); ++n) mm.push_back(static_cast<float>(n % 11));
  breathing::MotionField field(nodes, 1);
  return {.motion = {.name = "box",
                     .model = breathing::MotionModel::Sinusoid(std::move(field), 0.0),
                     .bound = breathing::MotionBound(nodes, std::move(mm))},
          .source = breathing::BreathSource(breathing::BreathingPattern({}), {}),
          .amplitude = amplitude,
          .from_session = true};
}

simulation::StepOutput StepAt(double x_mm) {
  simulation::StepOutput step;
  step.needle_at_rest.ct_from_tool.translation() = Eigen::Vector3d(x_mm, 50.0, 50.0);
  return step;
}

TEST(MotionBoundMetrics, AreOfTipAndTargets) {
  StepLog log;
  log.steps = {StepAt(20.0), StepAt(80.0), StepAt(45.0)};
  transforms::Markers targets(3, 1);
  targets << 30.0, 10.0, 10.0;
  const auto metrics = MotionBoundMetrics(BoundedBreathing(1.0), {}, log, targets);
  ASSERT_EQ(metrics.size(), 3);
  EXPECT_NEAR(metrics[0].value, 8.0, 1e-6);
  EXPECT_NEAR(metrics[1].value, 4.5, 1e-6);
  EXPECT_NEAR(metrics[2].value, 3.0, 1e-6);
  // Half of the motion, half of the bound.
  EXPECT_NEAR(MotionBoundMetrics(BoundedBreathing(0.5), {}, log, {})[0].value, 4.0, 1e-6);
}

TEST(MotionBoundMetrics, AreLeftOutWhereNothingIsKnown) {
  StepLog log;
  log.steps = {StepAt(20.0)};
  EXPECT_TRUE(MotionBoundMetrics(BoundedBreathing(0.0), {}, log, {}).empty());
  EXPECT_TRUE(MotionBoundMetrics(BoundedBreathing(1.0), {}, {}, {}).empty());
  auto unbounded = BoundedBreathing(1.0);
  unbounded.motion.bound.reset();
  EXPECT_TRUE(MotionBoundMetrics(unbounded, {}, log, {}).empty());
}

}  // namespace
}  // namespace acus::replay
