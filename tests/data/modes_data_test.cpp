// Brain cortex and meat, each in tension, compression and shear: what every law leaves.
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

#include "acus/patient/fitting/modes_fit.h"
#include "support/shared_data.h"

namespace acus::fitting {
namespace {

constexpr double kBound = 0.08;  ///< Of the RMS of the stress, all modes together.

double BestOf(const ModesFit& fit) {
  return fit.laws[*fit.best].relative_rms;
}

TEST(SeveralModes, OneLawFollowsTensionCompressionAndShear) {
  const auto root = testing_support::SharedData("mechanics");
  if (!root) GTEST_SKIP() << "test data mechanics is not here";
  for (const char* name : {"brain_cortex", "meat_ac"}) {
    SCOPED_TRACE(name);
    const ModesTest test = ReadModesTest(*root / "multi_mode" / (std::string(name) + ".csv"));
    const ModesFit fit = FitModes(test);
    ASSERT_TRUE(fit.converged) << fit.message;
    EXPECT_LT(BestOf(fit), kBound);
    double first_invariant = 1.0;  // The best of laws that know no other.
    for (const ModesLawFit& law : fit.laws) {
      if (law.name == "neo_hookean" || law.name == "yeoh" || law.name == "fung") {
        first_invariant = std::min(first_invariant, law.relative_rms);
      }
    }
    EXPECT_GT(first_invariant, 4.0 * BestOf(fit));
    std::printf(
        "  %s: %s leaves %.1f %% (tension %.1f, compression %.1f, shear %.1f); the best law "
        "of the first invariant %.1f %%\n",
        name, fit.laws[*fit.best].name.c_str(), 100.0 * BestOf(fit),
        100.0 * fit.laws[*fit.best].relative_rms_of[0],
        100.0 * fit.laws[*fit.best].relative_rms_of[1],
        100.0 * fit.laws[*fit.best].relative_rms_of[2], 100.0 * first_invariant);
  }
}

// What the fit is worth where it was not made: every second row of each mode.
TEST(SeveralModes, RowsThatWereNotFittedLieOnTheLaw) {
  const auto root = testing_support::SharedData("mechanics");
  if (!root) GTEST_SKIP() << "test data mechanics is not here";
  for (const char* name : {"brain_cortex", "meat_ac"}) {
    SCOPED_TRACE(name);
    const ModesTest whole = ReadModesTest(*root / "multi_mode" / (std::string(name) + ".csv"));
    ModesTest fitted{.name = name, .mode = {}, .amount = {}, .stress_mpa = {}};
    for (std::size_t i = 0; i < whole.mode.size(); i += 2) {
      fitted.mode.push_back(whole.mode[i]);
      fitted.amount.push_back(whole.amount[i]);
      fitted.stress_mpa.push_back(whole.stress_mpa[i]);
    }
    const ModesFit fit = FitModes(fitted);
    ASSERT_TRUE(fit.converged) << fit.message;
    const ModesLawFit& law = fit.laws[*fit.best];
    double off = 0.0;
    double all = 0.0;
    for (std::size_t i = 1; i < whole.mode.size(); i += 2) {
      off +=
          std::pow(ModeStressMpa(law.law, law.shear_modulus_mpa, whole.mode[i], whole.amount[i]) -
                       whole.stress_mpa[i],
                   2);
      all += std::pow(whole.stress_mpa[i], 2);
    }
    std::printf("  %s: rows that were not fitted %.1f %%\n", name, 100.0 * std::sqrt(off / all));
    EXPECT_LT(std::sqrt(off / all), kBound);
  }
}

}  // namespace
}  // namespace acus::fitting
