#include "benchmarks/forces_sweep.h"

#include <cmath>
#include <gmock/gmock.h>
#include <map>

#include "acus/base/core/error.h"
#include "benchmarks/friction_integration.h"
#include "benchmarks/sampled_run.h"

namespace acus::benchmarks {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

forces::LuGreParameters Stribeck() {
  return {.sigma0_per_mm = 2.592,
          .sigma1_s_per_mm = 0.000879,
          .sigma2_s_per_mm = 0.00204,
          .mu_coulomb = 0.052,
          .mu_static = 1.763,
          .beta_s_per_mm = 0.075,
          .speed_filter_s = 0.02};
}

double Rms(const FrictionRun& run, const FrictionRun& reference) {
  double sum = 0.0;
  for (std::size_t n = 0; n < run.force_n.size(); ++n) {
    sum += std::pow(run.force_n[n] - reference.force_n[n], 2);
  }
  return std::sqrt(sum / static_cast<double>(run.force_n.size()));
}

TEST(FrictionIntegration, TheReferenceIsConverged) {
  const FrictionRun reference = ReferenceFriction(Stribeck());
  EXPECT_LT(Rms(ReferenceFriction(Stribeck(), 0.01), reference), 1e-8);
  double most_n = 0.0;
  for (const double force_n : reference.force_n) most_n = std::max(most_n, std::abs(force_n));
  EXPECT_GT(most_n, 0.3);
  EXPECT_LT(most_n, 1.8);  // The static coefficient and the viscous part bound it.
}

TEST(FrictionIntegration, EveryMethodGoesToTheLawWithTheStep) {
  const FrictionRun reference = ReferenceFriction(Stribeck());
  for (const FrictionMethod method : kFrictionMethods) {
    const double coarse_n = Rms(RunFriction(Stribeck(), method, 0.1), reference);
    const double fine_n = Rms(RunFriction(Stribeck(), method, 0.05), reference);
    EXPECT_LT(coarse_n, 1e-3) << NameOf(method);
    EXPECT_LT(fine_n, 0.6 * coarse_n) << NameOf(method);
  }
}

// Explicit Euler is stable while sigma0 |v| T / g < 2: here at 215 mm/s up to 0.19 ms.
TEST(FrictionIntegration, OnlyTheExplicitMethodsDiverge) {
  const FrictionRun reference = ReferenceFriction(Stribeck());
  for (const double step_ms : {1.0, 2.0, 10.0}) {
    EXPECT_LT(Rms(RunFriction(Stribeck(), FrictionMethod::kShipped, step_ms), reference),
              0.003 * step_ms);
    EXPECT_LT(Rms(RunFriction(Stribeck(), FrictionMethod::kImplicitEuler, step_ms), reference),
              0.004 * step_ms);
    const double explicit_n =
        Rms(RunFriction(Stribeck(), FrictionMethod::kExplicitEuler, step_ms), reference);
    EXPECT_FALSE(explicit_n < 10.0) << step_ms;
  }
}

TEST(SmoothInsertion, HasNoJumpAndEndsOutside) {
  const auto samples = SamplesEvery(1.0);
  EXPECT_GT(samples.front().tip_in_ct_mm.z(), 2.9);
  EXPECT_GT(samples.back().tip_in_ct_mm.z(), 3.9);
  double lowest_mm = 0.0;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    EXPECT_LT((samples[n].tip_in_ct_mm - samples[n - 1].tip_in_ct_mm).norm(), 0.07);
    EXPECT_NEAR(samples[n].axis_in_ct.norm(), 1.0, 1e-12);
    lowest_mm = std::min(lowest_mm, samples[n].tip_in_ct_mm.z());
  }
  EXPECT_NEAR(lowest_mm, -46.0 * std::cos(4.0 * M_PI / 180.0), 1e-3);
  EXPECT_THAT([] { SamplesEvery(0.3); }, ThrowsMessage<InputError>(HasSubstr("0.3 ms")));
}

TEST(ForcesSweep, CoversStepMethodAndModelAndMarksWhatMustNotBeUsed) {
  const std::vector<Row> rows = ForcesSweep().run(true, {});
  std::map<std::string, int> knobs;
  std::map<std::string, int> defaults;
  for (const Row& row : rows) {
    ++knobs[row.knob];
    defaults[row.knob] += row.is_default;
    EXPECT_GT(row.step_us_median, 0.0);
    if (row.unusable.empty()) {
      EXPECT_GE(row.error, 0.0) << row.knob;
    } else {
      EXPECT_THAT(row.knob, testing::AnyOf(HasSubstr("explicit Euler"), HasSubstr("Runge")));
    }
    if (row.knob == "friction, Stribeck, explicit Euler: step_ms" && row.value == "1") {
      EXPECT_THAT(row.unusable, HasSubstr("unstable"));
    }
  }
  for (const char* knob :
       {"friction, exact over the step: step_ms", "layered: step_ms", "alamilla: step_ms",
        "vidal: step_ms", "springs: step_ms", "fe_2d: step_ms", "fe_3d: step_ms",
        "bendable needle: step_ms", "model"}) {
    EXPECT_EQ(defaults[knob], 2) << knob;  // RMS and largest.
  }
  EXPECT_EQ(knobs["model"], 14);
}

}  // namespace
}  // namespace acus::benchmarks
