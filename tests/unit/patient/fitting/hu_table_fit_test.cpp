#include "acus/patient/fitting/hu_table_fit.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/physics/forces/laws/hu_resistance.h"
#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// Force per speed by HU: fat little, muscle more.
double TruthNSPerMm(double hu) {
  return 0.05 + 0.15 / (1.0 + std::exp(-(hu - 20.0) / 25.0));
}

/// A path through fat, muscle and liver: HU from -110 to 130 with texture; edges where it changes.
forces::ForceCurve Path(std::uint64_t seed, double edge_factor, double friction_n_per_mm,
                        double speed_mm_per_s) {
  const DriveMotion drive{.rate_hz = 200.0, .speed_mm_per_s = speed_mm_per_s, .hold_s = 1.0};
  forces::ForceCurve curve = Motion(drive, "path" + std::to_string(seed));
  RandomStream noise(seed, "path");
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double d = curve.depth_mm[i] + 3.0 * static_cast<double>(seed);
    const double hu = 10.0 + 110.0 * std::sin(d / 9.0) + 10.0 * std::sin(d / 1.3);
    // Edges at all HU: where they go with the HU, nothing could tell them from the tissue.
    const double gradient = 60.0 * std::abs(std::cos(d / 2.1));
    curve.hu.push_back(hu);
    curve.hu_gradient_per_mm.push_back(gradient);
    const bool moves = i > 0 && curve.depth_mm[i] > curve.depth_mm[i - 1];
    const double edge = gradient > 40.0 ? edge_factor : 1.0;
    curve.force_n[i] =
        (moves ? speed_mm_per_s * edge * TruthNSPerMm(hu) + friction_n_per_mm * curve.depth_mm[i]
               : 0.0) +
        0.02 * noise.Normal();
  }
  return curve;
}

HuTableFit Fit(const std::vector<forces::ForceCurve>& curves) {
  std::vector<CurvePhases> phases;
  for (const forces::ForceCurve& curve : curves) phases.push_back(FindPhases(curve));
  return FitHuTable(curves, phases, std::vector<double>(curves.size(), 0.0));
}

TEST(HuTableFit, SeveralPathsGiveTheTableTheEdgeAndTheShaft) {
  std::vector<forces::ForceCurve> curves;
  for (std::uint64_t k = 0; k < 4; ++k) curves.push_back(Path(k, 1.6, 0.01, k % 2 ? 5.0 : 8.0));
  const HuTableFit fit = Fit(curves);
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.table.edge_factor, 1.6, 0.05);
  EXPECT_NEAR(fit.friction_n_per_mm.value, 0.01, 0.002);
  EXPECT_LT(fit.rms_n, 0.035);  // Noise, and steps of 0.1 mm that an edge of up to 1 N divides.
  for (double hu = -95.0; hu < 120.0; hu += 5.0) {
    EXPECT_NEAR(fit.table.ResistanceNSPerMm(hu), TruthNSPerMm(hu), 0.012) << hu;
  }
  EXPECT_EQ(fit.table.n_s_per_mm.size(), fit.table.hu.size() + 2);
  EXPECT_EQ(fit.n_s_per_mm.size(), fit.table.n_s_per_mm.size());
}

/// Root mean square of (estimate - truth) / standard error: 1 if the intervals are neither too
/// narrow nor too wide.
double SpreadInErrors(const std::vector<Estimate>& estimates, double truth) {
  double squares = 0.0;
  for (const Estimate& e : estimates) squares += std::pow((e.value - truth) / e.standard_error, 2);
  return std::sqrt(squares / static_cast<double>(estimates.size()));
}

TEST(HuTableFit, IntervalsOfEdgeAndShaftAreAsWideAsTheyScatter) {
  std::vector<Estimate> edge, friction;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const HuTableFit fit = Fit({Path(seed, 1.6, 0.01, 5.0)});
    ASSERT_TRUE(fit.converged) << fit.message;
    EXPECT_EQ(fit.edge_factor.value, fit.table.edge_factor);
    edge.push_back(fit.edge_factor);
    friction.push_back(fit.friction_n_per_mm);
  }
  // 40 draws give this ratio to within 11 % (SD).
  EXPECT_GT(SpreadInErrors(edge, 1.6), 0.65);
  EXPECT_LT(SpreadInErrors(edge, 1.6), 1.45);
  EXPECT_GT(SpreadInErrors(friction, 0.01), 0.65);
  EXPECT_LT(SpreadInErrors(friction, 0.01), 1.45);
}

/// Fat that resists nothing: its coefficients are held at 0, and the interval of each says how
/// large it could be.
TEST(HuTableFit, HeldCoefficientsHaveAnInterval) {
  forces::ForceCurve curve = Path(1, 1.0, 0.0, 5.0);
  RandomStream noise(1, "fat");
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const bool moves = i > 0 && curve.depth_mm[i] > curve.depth_mm[i - 1];
    curve.force_n[i] =
        (moves ? 5.0 * std::max(0.0, 0.002 * (curve.hu[i] - 10.0)) : 0.0) + 0.02 * noise.Normal();
  }
  const HuTableFit fit = Fit({curve});
  ASSERT_TRUE(fit.converged) << fit.message;
  int held = 0;
  for (const Estimate& e : fit.n_s_per_mm) {
    EXPECT_GE(e.low, 0.0);
    EXPECT_LE(e.low, e.value);
    EXPECT_GT(e.high, e.value);
    held += e.at_bound ? 1 : 0;
    if (e.at_bound) {
      EXPECT_EQ(e.value, 0.0);
      EXPECT_LT(e.high, 0.02);
    }
  }
  EXPECT_GE(held, 1);
}

TEST(HuTableFit, TheBlockIsWhatTheForceModelReads) {
  const HuTableFit fit = Fit({Path(1, 1.0, 0.0, 5.0)});
  ASSERT_TRUE(fit.converged);
  const nlohmann::json block = VidalBlock(fit.table);
  const forces::CubicBSpline spline(block["resistance"]["hu"].get<std::vector<double>>(),
                                    block["resistance"]["n_s_per_mm"].get<std::vector<double>>(),
                                    "test");
  for (double hu = -200.0; hu < 300.0; hu += 10.0) {
    EXPECT_NEAR(spline(hu), fit.table.ResistanceNSPerMm(hu), 1e-12);
    EXPECT_GE(spline(hu), 0.0);
  }
}

TEST(HuTableFit, SaysWhereNoRecordingComes) {
  forces::ForceCurve curve = Path(2, 1.0, 0.0, 5.0);
  for (double& hu : curve.hu) hu = hu > 10.0 ? 300.0 + 0.1 * hu : -100.0 + 0.1 * hu;
  const HuTableFit fit = Fit({curve});
  ASSERT_TRUE(fit.converged);
  EXPECT_THAT(fit.warnings, Contains(HasSubstr("no recording comes there")));
}

TEST(HuTableFit, WithoutEdgesTheFactorIsOne) {
  forces::ForceCurve curve = Path(3, 1.0, 0.0, 5.0);
  std::ranges::fill(curve.hu_gradient_per_mm, 0.0);
  const HuTableFit fit = Fit({curve});
  ASSERT_TRUE(fit.converged) << fit.message;
  EXPECT_EQ(fit.table.edge_factor, 1.0);
  EXPECT_LT(fit.rms_n, 0.03);
}

TEST(HuTableFit, WithoutHuThereIsNoAnswer) {
  const DriveMotion drive;
  const HuTableFit fit = Fit({Recording(PlainTruth(drive), drive, 0.01, 1)});
  EXPECT_FALSE(fit.converged);
  EXPECT_THAT(fit.message, HasSubstr("at least 40 are needed"));
}

}  // namespace
}  // namespace acus::fitting
