#include "acus/patient/registration/weighted_registration.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/patient/registration/error_bound.h"
#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::KnownPose;
using testing_support::SpreadMarkers;

/// A stereo camera: four times worse along its axis z, and the second half of the markers, seen
/// from the side, twice as bad as the first.
std::vector<MarkerNoise> CameraNoise(int count) {
  std::vector<MarkerNoise> noise(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double sd_mm = i < count / 2 ? 0.2 : 0.4;
    const Vector3d sd(sd_mm, sd_mm, 4 * sd_mm);
    noise[static_cast<std::size_t>(i)].reference_mm2 = sd.cwiseAbs2().asDiagonal();
    noise[static_cast<std::size_t>(i)].ct_mm2 = 0.01 * Matrix3d::Identity();
  }
  return noise;
}

struct Draw {
  transforms::Markers reference_mm;
  transforms::Markers ct_mm;
};

Draw Drawn(const transforms::Markers& reference_mm, const std::vector<MarkerNoise>& noise,
           std::uint64_t index) {
  RandomStream random(9, "camera noise", index);
  const auto normal = [&random](const Matrix3d& covariance) {
    return Vector3d(covariance.llt().matrixL() *
                    Vector3d(random.Normal(), random.Normal(), random.Normal()));
  };
  Draw draw{reference_mm, KnownPose() * reference_mm};
  for (Eigen::Index i = 0; i < reference_mm.cols(); ++i) {
    draw.reference_mm.col(i) += normal(noise[static_cast<std::size_t>(i)].reference_mm2);
    draw.ct_mm.col(i) += normal(noise[static_cast<std::size_t>(i)].ct_mm2);
  }
  return draw;
}

TEST(FitMarkersWeighted, IsThePlainFitForEqualIsotropicNoise) {
  const transforms::Markers reference_mm = SpreadMarkers(6);
  const transforms::Markers ct_mm =
      testing_support::NoisyMarkers(KnownPose() * reference_mm, 2.0, 1);
  const WeightedFit fit = FitMarkersWeighted(reference_mm, ct_mm, IsotropicNoise(6, 0.7));
  EXPECT_TRUE(
      fit.fit.ct_from_reference.isApprox(FitMarkers(reference_mm, ct_mm).ct_from_reference, 1e-10));
  EXPECT_NEAR(fit.chi_square, fit.fit.residual_mm.squaredNorm() / (0.49 / 3.0), 1e-8);
}

TEST(FitMarkersWeighted, RecoversAnExactPoseWhateverTheWeights) {
  const transforms::Markers reference_mm = SpreadMarkers(5);
  const WeightedFit fit =
      FitMarkersWeighted(reference_mm, KnownPose() * reference_mm, CameraNoise(5));
  EXPECT_TRUE(fit.fit.ct_from_reference.isApprox(KnownPose(), 1e-11));
  EXPECT_LT(fit.chi_square, 1e-15);
}

TEST(FitMarkersWeighted, RefusesAMarkerWithoutError) {
  auto noise = IsotropicNoise(4, 1.0);
  noise[2].ct_mm2(1, 1) = 0.0;
  EXPECT_THAT(
      [&] { FitMarkersWeighted(SpreadMarkers(4), SpreadMarkers(4), noise); },
      ThrowsMessage<InputError>(HasSubstr("marker 3: its localisation error is 0 in some")));
  noise[2].ct_mm2.setZero();
  EXPECT_THAT([&] { FitMarkersWeighted(SpreadMarkers(4), SpreadMarkers(4), noise); },
              ThrowsMessage<InputError>(HasSubstr("must be above 0")));
}

TEST(ErrorOfUnweightedFit, IsFitzpatricksFormulaForIsotropicNoise) {
  const transforms::Markers reference_mm = SpreadMarkers(5);
  const PoseError error = ErrorOfUnweightedFit(reference_mm, KnownPose(), IsotropicNoise(5, 0.6));
  for (const Vector3d& target_mm : {Vector3d(150, 20, 800), Vector3d(100, 0, 900)}) {
    const TreEstimate expected = ExpectedTre(KnownPose() * reference_mm, 0.6, target_mm);
    EXPECT_NEAR(error.At(target_mm).rms_mm, expected.rms_mm, 1e-10);
    EXPECT_TRUE(error.At(target_mm).covariance_mm2.isApprox(expected.covariance_mm2, 1e-9));
  }
}

// What the formulas promise against 8000 simulated registrations: the TRE of both fits, its
// covariance, the chi-square of the residuals, and how often the error is below the bound.
TEST(WeightedRegistration, ErrorsAreThosePredicted) {
  constexpr int kTrials = 8000;
  const transforms::Markers reference_mm = SpreadMarkers(7, 21);
  const auto noise = CameraNoise(7);
  const Vector3d target_mm = KnownPose() * Vector3d(30, -60, 90);
  const PoseError plain = ErrorOfUnweightedFit(reference_mm, KnownPose(), noise);
  double plain2 = 0.0, weighted2 = 0.0, chi_square = 0.0;
  const Draw exact{reference_mm, KnownPose() * reference_mm};
  const PoseError weighted = FitMarkersWeighted(exact.reference_mm, exact.ct_mm, noise).error;
  const double bound_mm = LengthBoundMm(weighted.At(target_mm).covariance_mm2, 0.95);
  int inside = 0;
  Matrix3d covariance = Matrix3d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    const Draw draw = Drawn(reference_mm, noise, static_cast<std::uint64_t>(trial));
    const WeightedFit fit = FitMarkersWeighted(draw.reference_mm, draw.ct_mm, noise);
    const MarkerFit simple = FitMarkers(draw.reference_mm, draw.ct_mm);
    const Vector3d source_mm = KnownPose().inverse() * target_mm;
    const Vector3d error_mm = fit.fit.ct_from_reference * source_mm - target_mm;
    plain2 += (simple.ct_from_reference * source_mm - target_mm).squaredNorm() / kTrials;
    weighted2 += error_mm.squaredNorm() / kTrials;
    chi_square += fit.chi_square / kTrials;
    covariance += error_mm * error_mm.transpose() / kTrials;
    inside += error_mm.norm() < bound_mm;
  }
  EXPECT_NEAR(std::sqrt(plain2) / plain.At(target_mm).rms_mm, 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(weighted2) / weighted.At(target_mm).rms_mm, 1.0, 0.02);
  EXPECT_LT(weighted2, 0.8 * plain2);  // It pays.
  EXPECT_NEAR(chi_square, 3 * 7 - 6, 0.3);
  const Matrix3d expected = weighted.At(target_mm).covariance_mm2;
  EXPECT_LT((covariance - expected).norm() / expected.norm(), 0.06);
  EXPECT_NEAR(static_cast<double>(inside) / kTrials, 0.95, 0.01);
}

}  // namespace
}  // namespace acus::registration
