#include "acus/patient/fitting/fitted_relaxation.h"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "acus/patient/fitting/fit_report.h"
#include "acus/physics/forces/models/needle_force.h"
#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

/// What is left of the force of a needle that slid at 5 mm/s, by a table with one tissue.
std::vector<double> LeftInAHold(const json& relaxation, const std::vector<double>& at_s) {
  const json document = {{"format", "acus-forces/1"},
                         {"tissues",
                          {{{"tissue", "soft_tissue"},
                            {"source", "test"},
                            {"friction_n_per_mm", 0.02},
                            {"relaxation", relaxation}}}}};
  const forces::NeedleForceModel model(
      forces::ForceTableFromJson(document, "fitted"),
      {.name = "18G", .gauge = 18, .length_mm = 150.0, .beam = {.outer_diameter_mm = 1.27}});
  forces::NeedleForceState state;
  const volume::Label label = volume::LabelOf("soft_tissue");
  const auto step = [&](double time_s, double depth_mm) {
    return model.Step(state, {time_s, {0, 0, depth_mm}, Eigen::Vector3d::UnitZ(), label, true})
        .AxialN();
  };
  double slid_n = 0.0;
  for (int i = 0; i <= 8000; ++i) slid_n = step(1e-3 * i, 5e-3 * i);
  std::vector<double> left;
  for (const double t : at_s) left.push_back(step(8.0 + t, 40.0) / slid_n);
  return left;
}

/// Held after sliding: 0.5 + 0.3 exp(-t / 0.4) + 0.2 exp(-t / 15) is left.
forces::ForceRelaxation Truth() {
  forces::ForceRelaxation truth;
  truth.share = {0.3, 0.2};
  truth.time_s = {0.4, 15.0};
  truth.num_terms = 2;
  return truth;
}
double TruthLeft(double held_s) {
  return 0.5 + 0.3 * std::exp(-held_s / 0.4) + 0.2 * std::exp(-held_s / 15.0);
}

TEST(FittedRelaxation, FallsInATableAsInTheHold) {
  const std::vector<double> at_s = {0.1, 1.0, 5.0, 30.0};
  const std::vector<double> left = LeftInAHold(RelaxationRow(Truth()), at_s);
  for (std::size_t i = 0; i < at_s.size(); ++i) {
    EXPECT_NEAR(left[i], TruthLeft(at_s[i]), 2e-3) << at_s[i] << " s";
  }
}

TEST(FittedRelaxation, FindsTheSeriesOfNoisyHolds) {
  std::vector<ForceCurve> curves;
  std::vector<PunctureCurveFit> fits;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ForceCurve curve = Motion({.hold_s = 60.0}, std::to_string(seed));
    PunctureCurveFit fit;
    fit.phases = FindPhases(curve);
    fit.offset_n = Estimate{.value = 0.1};
    RandomStream noise(seed, "hold");
    const double begin_s = curve.time_s[fit.phases.hold.begin];
    for (std::size_t i = 0; i < curve.time_s.size(); ++i) {
      const double held_s = std::max(0.0, curve.time_s[i] - begin_s);
      curve.force_n[i] = 0.1 + 1.3 * TruthLeft(held_s) + 0.01 * noise.Normal();
    }
    curves.push_back(std::move(curve));
    fits.push_back(std::move(fit));
  }
  std::vector<const ForceCurve*> pointers;
  for (const ForceCurve& curve : curves) pointers.push_back(&curve);
  const forces::ForceRelaxation found = FitHold(HoldCurve::MeanOf(pointers, fits));
  for (const double at_s : {0.1, 0.5, 2.0, 10.0, 50.0}) {
    double left = 1.0;
    for (int k = 0; k < found.num_terms; ++k) {
      left += found.share[k] * std::expm1(-at_s / found.time_s[k]);
    }
    EXPECT_NEAR(left, TruthLeft(at_s), 0.01) << at_s << " s";
  }
  EXPECT_GE(found.num_terms, 2);
}

TEST(FittedRelaxation, WithoutAHoldHasNoTerms) {
  const ForceCurve curve = Motion({.hold_s = 0.3});
  PunctureCurveFit fit;
  fit.phases = FindPhases(curve);
  const ForceCurve* pointer = &curve;
  EXPECT_TRUE(HoldCurve::MeanOf({&pointer, 1}, {&fit, 1}).left.empty());
  EXPECT_TRUE(RelaxationRow(FitHold({})).empty());
}

TEST(FittedRelaxation, NeverAsksMoreOfATableThanItMay) {
  forces::ForceRelaxation hold = Truth();
  hold.share = {0.6, 0.4};
  hold.time_s = {1e-3, 1e6};
  const json terms = RelaxationRow(hold);
  LeftInAHold(terms, {1.0});  // The table takes it.
  EXPECT_EQ(terms.back().at("time_s"), 1e4);
}

}  // namespace
}  // namespace acus::fitting
