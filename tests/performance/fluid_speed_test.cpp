// A step of fluid through the needle must leave the hand's millisecond to others.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/fluid/fluid_model.h"

namespace acus::fluid {
namespace {

// Measured 0.5 us (2.6 GHz): the whole table, a bubble, friction, two tissues at the bevel.
TEST(FluidSpeed, AStepTakesLessThanFiveMicroseconds) {
  const FluidTable table =
      ReadFluidTable(std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "fluid" / "default.json");
  const FluidModel model(table, table.SyringeNamed("plastic_10ml"), {5.0, 0.1},
                         {.inner_diameter_mm = 1.194, .length_mm = 80.0});
  FluidState state = model.NewState();
  constexpr int kStepsAtOnce = 100;  // One is too short for the clock.
  std::vector<double> step_us;
  double flow = 0.0;
  int n = 0;
  for (int batch = 0; batch < 300; ++batch) {
    const double begin_s = ThreadCpuSeconds();
    for (int i = 0; i < kStepsAtOnce; ++i, ++n) {
      FluidInput input;
      input.hand_n = 10.0 * std::sin(0.02 * n);
      input.coupling_n_s_per_mm = 0.5;
      const int tissue = 1 + n / 200 % (static_cast<int>(table.tissues.size()) - 2);
      input.bevel = {{{tissue, 0.7}, {tissue + 1, 0.3}}};
      input.tip_mm.z() = 0.001 * n;
      input.heart_cycles = 0.001 * n;
      flow += std::abs(model.Step(state, input, 1e-3).flow_ml_per_s);
    }
    step_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s) / kStepsAtOnce);
  }
  EXPECT_GT(flow, 0.0);
  std::printf("  median %.2f us, slowest hundred %.2f us\n", math::Median(step_us),
              *std::ranges::max_element(step_us));
  EXPECT_LT(math::Median(step_us), 5.0);
}

}  // namespace
}  // namespace acus::fluid
