#include "acus/physics/breathing/motion_model.h"

#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

/// Component n moves everything by n + 1 mm along x.
MotionField Shifts(int num_components) {
  volume::Geometry nodes;
  nodes.size = {2, 2, 2};
  nodes.spacing_mm = {100, 100, 100};
  MotionField field(nodes, num_components);
  for (int n = 0; n < num_components; ++n) {
    std::vector<float> values;
    for (int node = 0; node < 8; ++node) {
      values.insert(values.end(), {static_cast<float>(n + 1), 0.0F, 0.0F});
    }
    field.SetComponent(n, values);
  }
  return field;
}

double ShiftMm(const MotionModel& model, const Breath& breath, double amplitude = 1.0) {
  return model.field().DisplacementMm(model.WeightsAt(breath, amplitude), {10, 20, 30})[0];
}

TEST(MotionModel, FullCycleInterpolatesAndClosesTheCycle) {
  const auto model = MotionModel::FullCycle(
      Shifts(3), {{0.0, KeyFrame::kReference}, {0.25, 0}, {0.5, 1}, {0.75, 2}});
  EXPECT_EQ(model.WeightsAt({.cycle = 0.0}).count, 0);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.125}), 0.5, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.5}), 2.0, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.7}), 2.8, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.875}), 1.5, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.999999}), 0.0, 1e-3);
}

TEST(MotionModel, FullCycleClosesAlsoIfNoFrameIsAtItsBeginning) {
  const auto model = MotionModel::FullCycle(Shifts(2), {{0.2, 0}, {0.7, 1}});
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.95}), 1.5, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.0}), 1.4, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.cycle = 0.1}), 1.2, 1e-3);
}

TEST(MotionModel, HalfCycleContinuesBeyondItsEndsAlongTheLineBetweenThem) {
  const auto model =
      MotionModel::HalfCycle(Shifts(2), {{1.0, KeyFrame::kReference}, {0.5, 1}, {0.0, 0}});
  EXPECT_NEAR(ShiftMm(model, {.level = 0.5}), 2.0, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.level = 0.75}), 1.0, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.level = -0.5}), 1.5, 1e-3);  // Eq. 10.
  EXPECT_NEAR(ShiftMm(model, {.level = 1.4}), -0.4, 1e-3);
}

TEST(MotionModel, SurrogateIsLinearInSignalAndRate) {
  const auto model = MotionModel::Surrogate(Shifts(3));
  EXPECT_NEAR(ShiftMm(model, {.level = 2.0, .level_per_s = -0.5}), 1 * 2.0 - 2 * 0.5 + 3, 1e-3);
}

TEST(MotionModel, SinusoidOscillatesWithTheLevel) {
  const auto model = MotionModel::Sinusoid(Shifts(1), 1.0);
  EXPECT_EQ(model.WeightsAt({.level = 1.0}).count, 0);
  EXPECT_NEAR(ShiftMm(model, {.level = 0.0}), 1.0, 1e-3);
  EXPECT_NEAR(ShiftMm(model, {.level = -0.5}), 1.5, 1e-3);
}

TEST(MotionModel, WithoutAmplitudeOrWithoutASignalThePatientIsAsInTheReferenceImage) {
  const auto model = MotionModel::Surrogate(Shifts(3));
  EXPECT_EQ(model.WeightsAt({.level = 2.0}, 0.0).count, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(model.WeightsAt({.level = nan}).count, 0);
  EXPECT_EQ(model.WeightsAt({.level_per_s = nan}).count, 0);
  EXPECT_EQ(model.WeightsAt({.cycle = nan}).count, 0);
  EXPECT_NEAR(ShiftMm(model, {.level = 1.0}, 0.5), 2.0, 1e-3);
}

TEST(MotionModel, RefusesFramesThatAreTooFewOutOfOrderOrNotThere) {
  EXPECT_THROW(MotionModel::FullCycle(Shifts(2), {{0.0, 0}}), InputError);
  EXPECT_THROW(MotionModel::FullCycle(Shifts(2), {{0.5, 0}, {0.5, 1}}), InputError);
  EXPECT_THROW(MotionModel::FullCycle(Shifts(2), {{0.5, 0}, {1.0, 1}}), InputError);
  EXPECT_THROW(MotionModel::FullCycle(Shifts(2), {{-0.1, 0}, {0.5, 1}}), InputError);
  EXPECT_THROW(MotionModel::FullCycle(Shifts(2), {{0.1, 0}, {0.5, 2}}), InputError);
  EXPECT_THROW(MotionModel::HalfCycle(Shifts(2), {{0.0, 0}, {1.0, 1}, {0.5, 1}}), InputError);
  EXPECT_THROW(MotionModel::Surrogate(Shifts(2)), InputError);
}

}  // namespace
}  // namespace acus::breathing
