// The same motion at 500 Hz to 4 kHz gives the same forces in every force model.
#include <cstdio>
#include <gmock/gmock.h>

#include "benchmarks/force_model_cases.h"
#include "support/bound.h"

namespace acus::benchmarks {
namespace {

using testing_support::Above;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::HardCase;

// Stated in docs/models/forces_stability.md, for a step of T ms: 3 mN + 2 mN T root mean square,
// 20 mN + 60 mN T at most. It is the moment at which a skin, an interface or a membrane is met that
// a step finds only to its half; the force then runs off by up to 150 N/s.
TEST(StepRate, EveryForceModelFeelsTheSameFrom500HzTo4KHz) {
  const HardCase hard("One insertion at 500 Hz to 4 kHz against 16 kHz, in all seven models.");
  BoundPlot plot{.title = "Root mean square difference of the force from 16 kHz",
                 .x_label = "step [ms]",
                 .y_label = "difference [N]",
                 .log_x = true,
                 .log_y = true};
  const std::vector<ForceModelCase> models = ForceModelCases({}, {});
  ASSERT_EQ(models.size(), 7u);
  for (const ForceModelCase& model : models) {
    const SampledRun reference = model.run(SamplesEvery(0.0625));
    EXPECT_EQ(WhyUnusable(reference, model.largest_n), "");
    EXPECT_GE(reference.event_s.size(), 5u) << model.name;  // Contact, punctures, interfaces, out.
    plot.curves.push_back({.name = model.name});
    for (const double step_ms : {2.0, 1.0, 0.5, 0.25}) {
      const ForceDifference off = Difference(model.run(SamplesEvery(step_ms)), reference, step_ms);
      std::printf("  %-16s %4.0f Hz: rms %.4f N, largest %.4f N\n", model.name.c_str(),
                  1e3 / step_ms, off.rms_n, off.largest_n);
      const std::string of = Message(", ", model.name, ", ", step_ms, " ms");
      hard.Expect("root mean square difference" + of, off.rms_n, Below(0.003 + 0.002 * step_ms),
                  "N");
      hard.Expect("largest difference" + of, off.largest_n, Below(0.02 + 0.06 * step_ms), "N");
      EXPECT_GT(off.largest_n, 0.0) << model.name;
      plot.curves.back().Add(step_ms, off.rms_n);
    }
  }
  hard.Plot(plot);
}

// The comparison sees a force that depends on the step: a mean over m samples instead of over time.
TEST(StepRate, AMeanOverStepsInsteadOfTimeIsFound) {
  const HardCase hard("The comparison must see a force that does depend on the step.");
  struct MeanOverSteps {
    struct State {
      double mean_mm = 0.0;
    };
    State NewState() const { return {}; }
    forces::NeedleForce Step(State& state, const tissue::ToolSample& sample) const {
      state.mean_mm += 0.1 * (sample.tip_in_ct_mm.z() - state.mean_mm);
      forces::NeedleForce out;
      out.force_in_ct_n.z() = -0.05 * state.mean_mm;
      return out;
    }
  };
  const SampledRun reference = RunSampled(MeanOverSteps{}, SamplesEvery(0.0625), 16);
  const ForceDifference off =
      Difference(RunSampled(MeanOverSteps{}, SamplesEvery(2.0), 16), reference, 2.0);
  hard.Expect("difference of a mean over steps, which is seen", off.rms_n, Above(0.007), "N");
}

// Across the needle the rod is felt, so that the bound above is on it too.
TEST(StepRate, TheBendableNeedleIsNotTheRigidOne) {
  const std::vector<ForceModelCase> models = ForceModelCases({.element_mm = 12.0}, {});
  const auto samples = SamplesEvery(1.0);
  const SampledRun rigid = models.front().run(samples);
  const SampledRun bent = models.back().run(samples);
  double most_n = 0.0;
  for (std::size_t n = 0; n < bent.force_n.size(); ++n) {
    most_n = std::max(most_n, (bent.force_n[n] - rigid.force_n[n]).norm());
  }
  EXPECT_GT(most_n, 0.1);
}

}  // namespace
}  // namespace acus::benchmarks
