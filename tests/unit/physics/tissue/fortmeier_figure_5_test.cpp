// Fortmeier-2016, fig. 5, upper: what the paper's constants say that the curve must be.
#include <cmath>
#include <gtest/gtest.h>

#include "support/fortmeier_liver.h"

namespace acus::tissue {
namespace {

using testing_support::FortmeierAsPrinted;
using testing_support::FortmeierLiver;
using testing_support::FortmeierMotionMm;
using testing_support::FortmeierSprings;

double DepthOf(double force_n) {
  using L = FortmeierLiver;
  return (-L::kA1 + std::sqrt(L::kA1 * L::kA1 + 4.0 * L::kA2 * force_n)) / (2.0 * L::kA2);
}

/// Force at each sample of the figure's motion.
template <typename Force>
std::vector<double> Run(Force force) {
  std::vector<double> out;
  for (const double depth_mm : FortmeierMotionMm()) out.push_back(force(depth_mm));
  return out;
}

std::vector<double> SpringsRun(bool as_printed = false) {
  const SpringModel model = FortmeierSprings(as_printed);
  SpringState state = model.NewState();
  double time_s = 0.0;
  return Run([&](double depth_mm) {
    ToolSample sample;
    sample.time_s = time_s += 0.001;
    sample.tip_in_ct_mm.z() = depth_mm;
    return model.Step(state, sample).AxialN();
  });
}

std::vector<double> PrintedRun() {
  FortmeierAsPrinted printed;
  return Run([&](double depth_mm) { return printed.Step(depth_mm); });
}

/// On the way in, at a depth of the device.
double InAt(const std::vector<double>& force_n, double depth_mm) {
  return force_n[static_cast<std::size_t>(std::lround((depth_mm + 2.0) / 0.005))];
}
double OutAt(const std::vector<double>& force_n, double depth_mm) {
  return force_n[force_n.size() - 1 -
                 static_cast<std::size_t>(std::lround((depth_mm + 2.0) / 0.005))];
}

TEST(FortmeierFigure5, TheRiseIsThePolynomialToTheCapsulesForceAt17p8Millimetres) {
  const double puncture_mm = DepthOf(2.5);
  EXPECT_NEAR(puncture_mm, 17.79, 0.01);
  for (const auto& force_n : {PrintedRun(), SpringsRun()}) {
    for (const double depth_mm : {2.0, 5.0, 10.0, 15.0, 17.5}) {
      EXPECT_NEAR(InAt(force_n, depth_mm), 0.048 * depth_mm + 0.0052 * depth_mm * depth_mm, 0.005);
    }
    EXPECT_NEAR(*std::ranges::max_element(force_n), 2.5, 0.01);
    EXPECT_LT(InAt(force_n, puncture_mm + 0.1), 1.3);
  }
}

// Inside: 1 N at the tip and R / Delta p per mm of path.
TEST(FortmeierFigure5, InsideItIsCuttingPlusFrictionOfThePath) {
  const double per_mm = FortmeierLiver::kFrictionN / FortmeierLiver::kSpacingMm;
  const std::vector<double> printed = PrintedRun();
  // As printed the path's tip stays behind the device by what 1 N compresses: 10 mm.
  const double behind_mm = DepthOf(1.0);
  EXPECT_NEAR(behind_mm, 10.0, 0.02);
  const std::vector<double> springs = SpringsRun();
  for (const double depth_mm : {25.0, 30.0, 39.0}) {
    EXPECT_NEAR(InAt(printed, depth_mm), 1.0 + per_mm * (depth_mm - behind_mm), 0.03) << depth_mm;
    EXPECT_NEAR(InAt(springs, depth_mm), 1.0 + per_mm * depth_mm, 0.03) << depth_mm;
  }
  EXPECT_NEAR((InAt(springs, 39.0) - InAt(springs, 25.0)) / 14.0, per_mm, 0.1 * per_mm);
}

TEST(FortmeierFigure5, ThePauseHoldsAndWithdrawalIsFrictionAlone) {
  const double per_mm = FortmeierLiver::kFrictionN / FortmeierLiver::kSpacingMm;
  for (const auto& force_n : {PrintedRun(), SpringsRun()}) {
    EXPECT_NEAR(force_n[10300], force_n[8500], 1e-9);  // No relaxation in these springs.
    for (const double depth_mm : {25.0, 15.0, 5.0}) {
      EXPECT_NEAR(OutAt(force_n, depth_mm), -per_mm * depth_mm, 0.03) << depth_mm;
    }
    EXPECT_EQ(force_n.back(), 0.0);
  }
}

// With a1 and a2 inside the tissue and k from the force table, the springs are algorithm 1 as
// printed.
TEST(FortmeierFigure5, WithItsOwnConstantsTheSpringsAreTheAlgorithmAsPrinted) {
  const std::vector<double> printed = PrintedRun();
  const std::vector<double> springs = SpringsRun(true);
  double worst_n = 0.0;
  for (std::size_t i = 0; i < printed.size(); ++i) {
    worst_n = std::max(worst_n, std::abs(springs[i] - printed[i]));
  }
  std::printf("  as printed: largest difference %.4f N of %.2f N\n", worst_n,
              *std::ranges::max_element(printed));
  EXPECT_LT(worst_n, 0.02);
  EXPECT_NEAR(InAt(springs, 39.9), InAt(printed, 39.9), 0.005);
  EXPECT_NEAR(InAt(springs, 39.9), 1.37, 0.01);
}

}  // namespace
}  // namespace acus::tissue
