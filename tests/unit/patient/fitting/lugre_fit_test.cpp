#include "acus/patient/fitting/lugre_fit.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <map>
#include <numbers>

#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr LuGreParameters kTruth{.sigma0_n_per_mm = 2.5,
                                 .sigma1_n_s_per_mm = 0.02,
                                 .sigma2_n_s_per_mm = 0.004,
                                 .coulomb_n = 0.8,
                                 .static_n = 1.4,
                                 .stribeck_mm_per_s = 6.0,
                                 .growth_per_mm = 0.0,
                                 .middle_mm = 0.0,
                                 .offset_n = 0.1};

/// A periodic motion whose speed goes from 0 to 60 mm/s, reversals included.
forces::ForceCurve Periodic(double noise_n, std::uint64_t seed) {
  forces::ForceCurve curve;
  curve.name = "periodic";
  RandomStream noise(seed, "periodic");
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    const double amplitude_mm = t < 8.0 ? 2.0 : 10.0;
    curve.time_s.push_back(t);
    curve.depth_mm.push_back(20.0 + amplitude_mm * std::sin(2.0 * std::numbers::pi * 0.95 * t));
  }
  curve.force_n = ReplayLuGre(kTruth, curve.time_s, curve.depth_mm);
  for (double& force : curve.force_n) force += noise_n * noise.Normal();
  return curve;
}

/// Short, so that the Coulomb force and its ratio to the static one are both uncertain, and one
/// rises where the other falls.
forces::ForceCurve Slowed(double noise_n, std::uint64_t seed) {
  forces::ForceCurve curve;
  curve.name = "slowed";
  RandomStream noise(seed, "slowed");
  for (int i = 0; i < 800; ++i) {
    const double t = 0.01 * i;
    curve.time_s.push_back(t);
    curve.depth_mm.push_back(20.0 + 8.0 * std::sin(2.0 * std::numbers::pi * 0.5 * t));
  }
  curve.force_n = ReplayLuGre(kTruth, curve.time_s, curve.depth_mm);
  for (double& force : curve.force_n) force += noise_n * noise.Normal();
  return curve;
}

TEST(LuGreFit, PeriodicMotionGivesAllParameters) {
  const LuGreFit fit = FitLuGre(Periodic(0.01, 1));
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.rms_n, 0.01, 0.001);
  EXPECT_NEAR(fit.parameters.sigma0_n_per_mm, 2.5, 0.15);
  EXPECT_NEAR(fit.parameters.sigma2_n_s_per_mm, 0.004, 0.001);
  EXPECT_NEAR(fit.parameters.coulomb_n, 0.8, 0.05);
  EXPECT_NEAR(fit.parameters.static_n, 1.4, 0.1);
  EXPECT_NEAR(fit.parameters.stribeck_mm_per_s, 6.0, 1.0);
  EXPECT_NEAR(fit.parameters.offset_n, 0.1, 0.01);
  EXPECT_TRUE(fit.undetermined.empty()) << fit.undetermined[0];
  for (const auto& [name, e] : fit.estimates) {
    EXPECT_LT(e.low, e.high) << name;
    EXPECT_GT(e.standard_error, 0.0) << name;
  }
}

/// Root mean square of (estimate - truth) / standard error over recordings: 1 if the interval is
/// neither too narrow nor too wide.
TEST(LuGreFit, IntervalsAreAsWideAsTheEstimatesScatter) {
  const std::map<std::string, double> truth = {{"coulomb_n", kTruth.coulomb_n},
                                               {"static_n", kTruth.static_n},
                                               {"offset_n", kTruth.offset_n}};
  std::map<std::string, double> squares;
  constexpr int kSeeds = 30;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const LuGreFit fit = FitLuGre(Slowed(0.1, seed));
    ASSERT_TRUE(fit.converged);
    for (const auto& [name, e] : fit.estimates) {
      if (!truth.contains(name)) continue;
      squares[name] += std::pow((e.value - truth.at(name)) / e.standard_error, 2) / kSeeds;
    }
  }
  for (const auto& [name, square] : squares) {
    EXPECT_GT(std::sqrt(square), 0.6) << name;  // 30 draws: 13 % (SD).
    EXPECT_LT(std::sqrt(square), 1.4) << name;
  }
}

TEST(LuGreFit, OneSpeedDoesNotDetermineTheStribeckEffectAndSaysSo) {
  const DriveMotion drive;
  forces::ForceCurve curve = Recording(PlainTruth(drive), drive, 0.01, 1);
  const LuGreFit fit = FitLuGre(curve);
  ASSERT_TRUE(fit.converged);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("one speed only")));
  EXPECT_THAT(fit.undetermined, Contains("stribeck_mm_per_s"));
  EXPECT_THAT(fit.undetermined, Contains("static_n"));
  EXPECT_EQ(fit.parameters.sigma2_n_s_per_mm, 0.0);
  EXPECT_EQ(fit.parameters.static_n, fit.parameters.coulomb_n);
}

TEST(LuGreFit, ANeedleThatRestsOrIsHardlyRecordedIsNoAnswer) {
  forces::ForceCurve still = Motion({});
  std::ranges::fill(still.depth_mm, 10.0);
  EXPECT_FALSE(FitLuGre(still).converged);
  EXPECT_THAT(FitLuGre(still).message, HasSubstr("does not move"));
  forces::ForceCurve few;
  few.time_s = {0.0, 1.0};
  few.depth_mm = {0.0, 5.0};
  few.force_n = {0.0, 1.0};
  EXPECT_THAT(FitLuGre(few).message, HasSubstr("too few"));
  EXPECT_FALSE(FitLuGre({}).converged);
}

TEST(LuGreReplay, StaysBoundedAtAnySpeedAndStep) {
  std::vector<double> time_s;
  std::vector<double> depth_mm;
  for (int i = 0; i < 1000; ++i) {
    time_s.push_back(0.01 * i);
    depth_mm.push_back(i % 2 == 0 ? 0.0 : 500.0);  // 50 m/s, reversing.
  }
  LuGreParameters p = kTruth;
  p.sigma1_n_s_per_mm = 0.0;
  p.sigma2_n_s_per_mm = 0.0;
  for (const double force : ReplayLuGre(p, time_s, depth_mm)) {
    EXPECT_LE(std::abs(force - p.offset_n), p.static_n + 1e-9);
  }
}

}  // namespace
}  // namespace acus::fitting
