#include "acus/patient/fitting/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <map>

#include "acus/base/core/random.h"

namespace acus::fitting {
namespace {

using forces::CurveParameters;
using forces::DrivePlan;
using forces::SynthesizeForceCurve;

using testing::HasSubstr;

/// What the fit's parameters should be for a synthetic curve, under the fit's names.
std::map<std::string, double> Truth(const CurveParameters& truth) {
  return {{"offset_n", truth.offset_n},
          {"contact_depth_mm", truth.contact_depth_mm},
          {"a1_n_per_mm", truth.a1_n_per_mm},
          {"a2_n_per_mm2", truth.a2_n_per_mm2},
          {"puncture_depth_mm", truth.puncture_depth_mm},
          {"puncture_n", truth.PunctureForceN()},
          {"drop_n", truth.PunctureForceN() - truth.plateau_n},
          {"plateau_n", truth.plateau_n},
          {"plateau_slope_n_per_mm", truth.plateau_slope_n_per_mm},
          {"friction_n_per_mm", truth.friction_n_per_mm},
          {"relaxation_fraction", truth.relaxation_fraction},
          {"relaxation_time_s", truth.relaxation_time_s}};
}

struct Coverage {
  std::map<std::string, int> inside;  ///< Seeds in which the parameter is in its own interval.
  int all_jointly = 0;  ///< Seeds in which all are in their intervals for several at once.
  int converged = 0;
};

/// Other parameters for each seed: shallow and deep, soft and stiff, strong and weak punctures.
CurveParameters AnyTruth(std::uint64_t seed) {
  RandomStream random(seed, "truth");
  CurveParameters truth;
  truth.contact_depth_mm = random.Uniform(0.5, 12.0);
  truth.a1_n_per_mm = random.Uniform(0.02, 0.3);
  truth.a2_n_per_mm2 = random.Uniform(0.002, 0.05);
  truth.puncture_depth_mm = random.Uniform(4.0, 15.0);
  truth.plateau_n = random.Uniform(0.2, 0.7) * truth.PunctureForceN();
  truth.plateau_slope_n_per_mm = random.Uniform(0.0, 0.03);
  truth.friction_n_per_mm = random.Uniform(0.005, 0.03);
  truth.relaxation_fraction = random.Uniform(0.1, 0.7);
  truth.relaxation_time_s = random.Uniform(0.5, 3.0);
  truth.offset_n = random.Uniform(-0.5, 0.5);
  return truth;
}

struct Case {
  const char* name;
  CurveParameters truth;
  DrivePlan plan;
  double noise_n;
  bool any_truth = false;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

Coverage CoverageOver100Seeds(const Case& c) {
  Coverage coverage;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const CurveParameters truth = c.any_truth ? AnyTruth(seed) : c.truth;
    const auto expected = Truth(truth);
    const PunctureCurveFit fit =
        FitPunctureCurve(SynthesizeForceCurve(truth, c.plan, c.noise_n, seed, "seed"));
    if (!fit.converged) std::printf("  seed %d: %s\n", static_cast<int>(seed), fit.message.c_str());
    coverage.converged += fit.converged ? 1 : 0;
    std::size_t joint = 0;
    for (const auto& [name, estimate] : fit.Estimates()) {
      const double value = expected.at(name);
      coverage.inside[name] += estimate.Contains(value) ? 1 : 0;
      joint += estimate.AmongSeveral(static_cast<int>(expected.size())).Contains(value) ? 1u : 0u;
    }
    coverage.all_jointly += joint == expected.size() ? 1 : 0;
  }
  return coverage;
}

class FitCoverage : public testing::TestWithParam<Case> {};

TEST_P(FitCoverage, HoldsTheTruthInAtLeast90Of100Seeds) {
  const Case& c = GetParam();
  const Coverage coverage = CoverageOver100Seeds(c);
  EXPECT_EQ(coverage.converged, 100);
  for (const auto& [name, value] : Truth(c.truth)) {
    const auto found = coverage.inside.find(name);
    const int inside = found == coverage.inside.end() ? 0 : found->second;
    std::printf("  %-8s %-24s %3d of 100\n", c.name, name.c_str(), inside);
    EXPECT_GE(inside, 90) << c.name << " " << name;
  }
  std::printf("  %-8s %-24s %3d of 100\n", c.name, "all at once", coverage.all_jointly);
  EXPECT_GE(coverage.all_jointly, 90) << c.name;
}

INSTANTIATE_TEST_SUITE_P(
    Curves, FitCoverage,
    testing::Values(
        Case{"liver", {.offset_n = 0.12}, {}, 0.02},
        Case{"noisy",
             {.contact_depth_mm = 8.0, .puncture_depth_mm = 15.0, .offset_n = -0.3},
             {.rate_hz = 500.0},
             0.08},
        Case{"slow", {.offset_n = 0.05}, {.rate_hz = 200.0, .advance_mm_per_s = 2.0}, 0.01},
        Case{"any", {}, {.hold_s = 5.0}, 0.02, /*any_truth=*/true}),
    [](const auto& tested) { return tested.param.name; });

TEST(FitPunctureCurve, IsExactWithoutNoise) {
  const CurveParameters truth{.offset_n = 0.1};
  const PunctureCurveFit fit = FitPunctureCurve(SynthesizeForceCurve(truth, {}, 0.0, 1, "clean"));
  ASSERT_TRUE(fit.converged) << fit.message;
  const auto expected = Truth(truth);
  for (const auto& [name, estimate] : fit.Estimates()) {
    const double tolerance =
        name == "puncture_depth_mm" || name == "relaxation_time_s" ? 3e-3 : 5e-4;
    EXPECT_NEAR(estimate.value, expected.at(name), tolerance) << name;
  }
}

TEST(FitPunctureCurve, SaysWhyThereIsNoAnswer) {
  const ForceCurve whole = SynthesizeForceCurve({}, {}, 0.02, 1, "x");
  ForceCurve flat = whole;
  for (double& force : flat.force_n) force = 0.1;
  EXPECT_FALSE(FitPunctureCurve(flat).converged);
  EXPECT_THAT(FitPunctureCurve(flat).message, HasSubstr("no puncture"));
  ForceCurve still = whole;
  for (double& depth : still.depth_mm) depth = 3.0;
  EXPECT_THAT(FitPunctureCurve(still).message, HasSubstr("does not advance"));
  ForceCurve cut = whole;  // Ends before the puncture.
  for (auto* column : {&cut.time_s, &cut.depth_mm, &cut.force_n}) column->resize(3500);
  EXPECT_FALSE(FitPunctureCurve(cut).converged);
}

// Any numbers at all: a fit or a message, never a crash or an endless loop.
TEST(FitPunctureCurve, SurvivesNonsense) {
  RandomStream random(3, "nonsense");
  for (int i = 0; i < 60; ++i) {
    ForceCurve curve;
    const auto n = static_cast<std::size_t>(random.Uniform(20, 600));
    double time = 0.0;
    double depth = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      time += random.Uniform(1e-6, i % 3 == 0 ? 1.0 : 0.01);
      depth = i % 4 == 0 ? random.Uniform(-2000, 2000) : depth + random.Uniform(-0.1, 0.15);
      curve.time_s.push_back(time);
      curve.depth_mm.push_back(depth);
      curve.force_n.push_back(i % 5 == 0 ? 0.0 : random.Uniform(-1000, 1000));
    }
    const PunctureCurveFit fit = FitPunctureCurve(curve);
    EXPECT_TRUE(fit.converged || !fit.message.empty());
    for (const auto& [name, estimate] : fit.Estimates())
      EXPECT_TRUE(std::isfinite(estimate.value)) << name;
  }
}

TEST(PunctureCurveFit, TakesTheLevelInAirAsTheSensorsZero) {
  CurveParameters truth;
  truth.contact_depth_mm = 8.0;
  for (const double offset_n : {0.4, -0.4}) {
    truth.offset_n = offset_n;
    DrivePlan plan;
    plan.rest_s = 0.0;  // The recording begins while the needle is driven through air.
    plan.rate_hz = 200.0;
    const auto fit = FitPunctureCurve(SynthesizeForceCurve(truth, plan, 0.01, 3, "approach"));
    ASSERT_TRUE(fit.converged) << fit.message;
    ASSERT_TRUE(fit.offset_n);
    EXPECT_NEAR(fit.offset_n->value, offset_n, 0.02);
    EXPECT_NEAR(fit.plateau_n->value, truth.plateau_n, 0.05);
    EXPECT_FALSE(fit.starts_in_tissue);
  }
}

TEST(PunctureCurveFit, HasNoAnswerWhereTheSensorsZeroIsNotInTheRecording) {
  const CurveParameters truth;  // Contact at 5 mm, puncture at 17 mm.
  DrivePlan plan;
  plan.rest_s = 0.0;
  plan.rate_hz = 200.0;
  const auto whole = SynthesizeForceCurve(truth, plan, 0.002, 3, "whole");
  const auto from = [&](double depth_mm, double offset_n) {
    ForceCurve curve = whole;
    const auto begin =
        std::ranges::find_if(whole.depth_mm, [&](double d) { return d >= depth_mm; }) -
        whole.depth_mm.begin();
    for (auto* column : {&curve.time_s, &curve.depth_mm, &curve.force_n}) {
      column->erase(column->begin(), column->begin() + begin);
    }
    for (double& force_n : curve.force_n) force_n += offset_n;
    return FitPunctureCurve(curve);
  };
  for (const double inside_mm : {9.0, 11.0, 13.0}) {
    const auto fit = from(inside_mm, 0.0);
    EXPECT_FALSE(fit.converged) << inside_mm;
    EXPECT_FALSE(fit.plateau_n) << inside_mm;
    EXPECT_THAT(fit.message, HasSubstr("begins inside tissue, or the sensor's zero")) << inside_mm;
  }
  EXPECT_FALSE(from(truth.contact_depth_mm, 0.4).converged);
  // From contact on, with a sensor that was set to zero before.
  const auto fit = from(truth.contact_depth_mm, 0.0);
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.plateau_n->value, truth.plateau_n, 0.05);
}

}  // namespace
}  // namespace acus::fitting
