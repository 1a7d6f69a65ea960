#include "acus/patient/registration/error_bound.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/math/distributions.h"
#include "acus/patient/registration/rigid_registration.h"
#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(LengthBound, IsTheRootOfChiSquareForASphere) {
  for (const double confidence : {0.5, 0.95, 0.99}) {
    const double bound_mm = LengthBoundMm(4.0 * Matrix3d::Identity(), confidence);
    EXPECT_NEAR(math::ChiSquareUpperTail(bound_mm * bound_mm / 4.0, 3.0), 1.0 - confidence, 1e-5);
  }
}

TEST(LengthBound, HoldsForFlatAndThinCovariances) {
  // A disc: Rayleigh. A needle: 1.96 standard deviations.
  EXPECT_NEAR(LengthBoundMm(Vector3d(1, 1, 0).asDiagonal(), 0.95), std::sqrt(-2 * std::log(0.05)),
              2e-3);
  EXPECT_NEAR(LengthBoundMm(Vector3d(9, 0, 0).asDiagonal(), 0.95), 3 * 1.959964, 6e-3);
  EXPECT_EQ(LengthBoundMm(Matrix3d::Zero(), 0.95), 0.0);
}

TEST(LengthBound, OfAnEstimatedVarianceIsFForASphere) {
  // |e|^2 / (3 s^2) is F with 3 and k degrees of freedom.
  for (const double freedom : {6.0, 12.0, 40.0}) {
    const double bound_mm = LengthBoundMm(Matrix3d::Identity(), 0.95, freedom);
    EXPECT_NEAR(math::FUpperTail(bound_mm * bound_mm / 3.0, 3.0, freedom), 0.05, 2e-3) << freedom;
  }
}

TEST(DeviationInterval, IsThatOfTheTextbooks) {
  // chi2 with 9 degrees of freedom: 2.700 and 19.023 at 2.5 % and 97.5 %.
  const DeviationInterval interval = DeviationIntervalOf(9.0, 0.95);
  EXPECT_NEAR(interval.low, std::sqrt(9.0 / 19.0228), 1e-4);
  EXPECT_NEAR(interval.high, std::sqrt(9.0 / 2.70039), 1e-4);
}

// A user who knows no FLE: the error at the target is below the stated bound as often as stated.
TEST(LengthBound, HoldsAsOftenAsStatedWhenTheFleComesFromTheResiduals) {
  constexpr int kTrials = 2000;
  for (const int count : {4, 8}) {
    const transforms::Markers markers_mm = testing_support::SpreadMarkers(count, 40);
    const Vector3d target_mm(150, 20, -60);
    const Matrix3d unit = ExpectedTre(markers_mm, 1.0, target_mm).covariance_mm2;
    const double unit_bound_mm = LengthBoundMm(unit, 0.95, 3.0 * count - 6.0);
    int inside = 0;
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      const MarkerFit fit =
          FitMarkers(markers_mm, testing_support::NoisyMarkers(markers_mm, 0.8, trial));
      const double fle_mm = FleFromFreMm(fit.fre_rms_mm, count);
      inside += (fit.ct_from_reference * target_mm - target_mm).norm() < fle_mm * unit_bound_mm;
    }
    EXPECT_NEAR(static_cast<double>(inside) / kTrials, 0.95, 0.015) << count;
  }
}

}  // namespace
}  // namespace acus::registration
