#include "acus/patient/fitting/gaussian_fit.h"

#include <cmath>
#include <gtest/gtest.h>

#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

forces::ForceCurve CurveOf(const std::vector<Gaussian>& terms, double noise_n, std::uint64_t seed) {
  forces::ForceCurve curve = Motion({});
  RandomStream noise(seed, "gaussians");
  for (std::size_t i = 0; i < curve.size(); ++i) {
    curve.force_n[i] = SumN(terms, curve.depth_mm[i]) + noise_n * noise.Normal();
  }
  return curve;
}

TEST(GaussianFit, FindsTheTermsThatAreThere) {
  const std::vector<Gaussian> truth = {{1.0, 12.0, 3.0}, {2.0, 30.0, 6.0}, {0.7, 48.0, 2.0}};
  const forces::ForceCurve curve = CurveOf(truth, 0.01, 1);
  const GaussianFit fit = FitGaussians(curve, FindPhases(curve), 3);
  ASSERT_TRUE(fit.converged);
  ASSERT_EQ(fit.terms.size(), 3u);
  ASSERT_EQ(fit.height_n.size(), 3u);
  EXPECT_NEAR(fit.rms_n, 0.01, 0.001);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(fit.terms[k].height_n, truth[k].height_n, 0.02);
    EXPECT_NEAR(fit.terms[k].centre_mm, truth[k].centre_mm, 0.1);
    EXPECT_NEAR(fit.terms[k].width_mm, truth[k].width_mm, 0.1);
    EXPECT_LT(fit.centre_mm[k].standard_error, 0.1);
  }
}

TEST(GaussianFit, EightTermsFollowAPunctureWithinThreeHundredthsOfItsHeight) {
  DriveMotion drive;
  MechanicalModel truth = PlainTruth(drive);
  truth.punctures = {{.contact_mm = 20.0,
                      .puncture_mm = 6.0,
                      .a1_n_per_mm = 0.1,
                      .a2_n_per_mm2 = 0.02,
                      .recovery_mm = 0.5,
                      .step_n = 0.2}};
  const forces::ForceCurve curve = Recording(truth, drive, 0.005, 3);
  const GaussianFit fit = FitGaussians(curve, FindPhases(curve));
  ASSERT_TRUE(fit.converged);
  EXPECT_EQ(fit.terms.size(), 8u);
  EXPECT_LT(fit.rms_n, 0.04);  // The peak is 1.3 N above its ground.
}

TEST(GaussianFit, MoreTermsLeaveLessAndTheSameCurveGivesTheSameBits) {
  const forces::ForceCurve curve =
      CurveOf({{1.0, 12.0, 3.0}, {2.0, 30.0, 6.0}, {0.7, 48.0, 2.0}}, 0.01, 2);
  const CurvePhases phases = FindPhases(curve);
  double before = 1e9;
  for (const int count : {1, 2, 3}) {
    const double rms = FitGaussians(curve, phases, count).rms_n;
    EXPECT_LT(rms, before);
    before = rms;
  }
  const GaussianFit a = FitGaussians(curve, phases, 3);
  const GaussianFit b = FitGaussians(curve, phases, 3);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(a.terms[k].centre_mm, b.terms[k].centre_mm);
}

TEST(GaussianFit, AnInsertionThatIsTooShortIsNoAnswer) {
  const forces::ForceCurve curve = Recording(PlainTruth({}), {.end_mm = 0.8}, 0.0, 1);
  const GaussianFit fit = FitGaussians(curve, FindPhases(curve));
  EXPECT_FALSE(fit.converged);
  EXPECT_NE(fit.message.find("too short"), std::string::npos);
}

}  // namespace
}  // namespace acus::fitting
