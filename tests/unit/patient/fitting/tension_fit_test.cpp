#include "acus/patient/fitting/tension_fit.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::fitting {
namespace {

double EnergyMpa(HyperelasticLaw law, const std::vector<double>& p, double stretch) {
  const double e = stretch * stretch + 2.0 / stretch - 3.0;
  switch (law) {
    case HyperelasticLaw::kNeoHookean:
      return 0.5 * p[0] * e;
    case HyperelasticLaw::kYeoh:
      return p[0] * e + p[1] * e * e + p[2] * e * e * e;
    case HyperelasticLaw::kFung:
      return 0.5 * p[0] / p[1] * (std::exp(p[1] * e) - 1.0);
  }
  return 0.0;
}

std::vector<double> TruthOf(HyperelasticLaw law) {
  if (law == HyperelasticLaw::kNeoHookean) return {0.5};
  if (law == HyperelasticLaw::kYeoh) return {0.1, 0.3, 0.2};
  return {0.3, 1.5};
}

/// A strip of 30 x 8 x 2 mm with 1.5 mm of slack, pulled to 15 mm, torn there.
TensionTest Strip(HyperelasticLaw law, double noise_n, std::uint64_t seed) {
  TensionTest test{.name = "strip",
                   .length_mm = 30.0,
                   .width_mm = 8.0,
                   .thickness_mm = 2.0,
                   .time_s = {},
                   .elongation_mm = {},
                   .force_n = {}};
  RandomStream noise(seed, "strip");
  for (int i = 0; i <= 1700; ++i) {
    const double e = 0.01 * i;
    const double stretch = (30.0 + e) / 31.5;
    const double force = e > 15.0 ? 0.0 : 16.0 * NominalStressMpa(law, TruthOf(law), stretch);
    test.time_s.push_back(0.1 * i);
    test.elongation_mm.push_back(e);
    test.force_n.push_back(force + noise_n * noise.Normal());
  }
  return test;
}

// In uniaxial tension of an incompressible solid P = dW/dlambda.
TEST(HyperelasticLaws, StressIsTheSlopeOfTheEnergy) {
  for (const HyperelasticLaw law : kHyperelasticLaws) {
    for (const double stretch : {1.01, 1.2, 1.8}) {
      const std::vector<double> p = TruthOf(law);
      const double h = 1e-6;
      const double slope =
          (EnergyMpa(law, p, stretch + h) - EnergyMpa(law, p, stretch - h)) / (2.0 * h);
      EXPECT_NEAR(NominalStressMpa(law, p, stretch), slope, 1e-7 * std::max(1.0, slope))
          << NameOf(law) << " " << stretch;
    }
    EXPECT_EQ(NominalStressMpa(law, TruthOf(law), 0.9), 0.0);
    EXPECT_TRUE(std::isfinite(NominalStressMpa(law, {{0.3, 1e9, 1.0}}, 50.0)));
  }
}

TEST(TensionFit, FindsTheLawItsParametersAndTheSlack) {
  for (const HyperelasticLaw law : kHyperelasticLaws) {
    SCOPED_TRACE(NameOf(law));
    const TensionTest test = Strip(law, 0.02, 3);
    const TensionFit fit = FitTension(test);
    ASSERT_TRUE(fit.converged) << fit.message;
    EXPECT_NEAR(test.elongation_mm[fit.end - 1], 15.0, 0.1);
    const LawFit& own = fit.laws[static_cast<std::size_t>(law)];
    EXPECT_NEAR(own.slack_mm.value, 1.5, 0.05);
    EXPECT_LT(own.relative_rms, 0.005);
    // A law that holds this one as a special case cannot be worse.
    EXPECT_LE(fit.laws[*fit.best].aic, own.aic);
    if (law == HyperelasticLaw::kFung) {
      EXPECT_EQ(*fit.best, static_cast<std::size_t>(law));
    }
    for (std::size_t k = 0; k < own.parameters.size(); ++k) {
      EXPECT_NEAR(own.parameters[k].value, TruthOf(law)[k], 0.03) << ParametersOf(law)[k];
    }
  }
}

TEST(TensionFit, IntervalsHoldTheTruth) {
  const HyperelasticLaw law = HyperelasticLaw::kFung;
  int inside[3] = {};
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const LawFit fit = FitTension(Strip(law, 0.05, seed)).laws[static_cast<std::size_t>(law)];
    ASSERT_TRUE(fit.converged);
    inside[0] += fit.slack_mm.Contains(1.5) ? 1 : 0;
    for (std::size_t k = 0; k < 2; ++k) {
      inside[k + 1] += fit.parameters[k].Contains(TruthOf(law)[k]) ? 1 : 0;
    }
  }
  for (const int count : inside) EXPECT_GE(count, 35);
}

TEST(TensionFit, AStripThatIsNotPulledIsNoAnswer) {
  TensionTest test = Strip(HyperelasticLaw::kNeoHookean, 0.0, 1);
  for (double& e : test.elongation_mm) e = 2.0;
  EXPECT_FALSE(FitTension(test).converged);
  EXPECT_FALSE(FitTension(test).message.empty());
  for (double& f : test.force_n) f = 0.0;
  EXPECT_FALSE(FitTension(test).converged);
}

}  // namespace
}  // namespace acus::fitting
