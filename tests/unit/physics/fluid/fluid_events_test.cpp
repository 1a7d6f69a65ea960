#include "acus/physics/fluid/fluid_events.h"

#include <gtest/gtest.h>

namespace acus::fluid {
namespace {

constexpr double kDtS = 1e-3;

/// Runs a pressure from one value to another, linearly, with a flow.
int Losses(double from_kpa, double to_kpa, double over_s, double flow_ml_per_s,
           FluidEvents& events) {
  for (int i = 0; i < 500; ++i) {
    events.Advance({}, {.syringe_kpa = from_kpa}, kDtS);
  }
  const int num = static_cast<int>(over_s / kDtS);
  for (int i = 1; i <= num; ++i) {
    FluidOutput output;
    output.syringe_kpa = from_kpa + (to_kpa - from_kpa) * i / num;
    output.flow_ml_per_s = flow_ml_per_s;
    events.Advance({}, output, kDtS);
  }
  return events.num_losses;
}

TEST(FluidEvents, AFallWithFlowIsALossOfResistance) {
  FluidEvents events;
  EXPECT_EQ(Losses(50.0, 5.0, 0.3, 1.0, events), 1);
  EXPECT_DOUBLE_EQ(events.before_loss_kpa, 50.0);
  EXPECT_NEAR(events.fall_time_s, 0.3 * 20.0 / 45.0, 0.002);
  EXPECT_DOUBLE_EQ(events.peak_kpa, 50.0);
}

TEST(FluidEvents, AThumbThatLetsGoIsNone) {
  FluidEvents events;
  EXPECT_EQ(Losses(50.0, 5.0, 0.3, 0.0, events), 0);
}

TEST(FluidEvents, ASlowFallOrALowPressureIsNone) {
  FluidEvents slow;
  EXPECT_EQ(Losses(50.0, 5.0, 20.0, 1.0, slow), 0);
  FluidEvents low;
  EXPECT_EQ(Losses(5.0, 0.5, 0.3, 1.0, low), 0);
}

TEST(FluidEvents, CountsDropsAndTheirRate) {
  FluidEvents events;
  for (int i = 0; i < 40000; ++i) events.Advance({}, {.hub_ml_per_s = 1.0 / 40.0}, kDtS);
  EXPECT_NEAR(events.num_drops, 20, 1);
  EXPECT_NEAR(events.drops_per_min, 30.0, 0.1);
}

TEST(FluidEvents, SumsTheTimeAboveTheLimit) {
  FluidEvents events;
  Losses(120.0, 60.0, 0.2, 0.0, events);
  EXPECT_NEAR(events.above_limit_s, 0.5 + 0.2 * 16.6 / 60.0, 0.002);
}

}  // namespace
}  // namespace acus::fluid
