#include "acus/patient/registration/rigid_registration.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

const Isometry3d kTruth =
    Eigen::Translation3d(120.0, -35.0, 840.0) * AngleAxisd(2.5, Vector3d(1, 2, -1).normalized());

transforms::Markers Spread(int count, std::uint64_t seed = 7) {
  RandomStream random(seed, "markers");
  transforms::Markers markers_mm(3, count);
  for (double& x : markers_mm.reshaped()) x = random.Uniform(-100, 100);
  return markers_mm;
}

/// `markers_mm` with isotropic normal errors of RMS length fle_rms_mm.
transforms::Markers Noisy(transforms::Markers markers_mm, double fle_rms_mm, std::uint64_t index) {
  RandomStream random(3, "noise", index);
  for (double& x : markers_mm.reshaped()) x += fle_rms_mm / std::sqrt(3.0) * random.Normal();
  return markers_mm;
}

TEST(FitMarkers, RecoversAnExactPose) {
  for (const int count : {3, 4, 20}) {
    const transforms::Markers reference_mm = Spread(count);
    const MarkerFit fit = FitMarkers(reference_mm, kTruth * reference_mm);
    EXPECT_TRUE(fit.ct_from_reference.isApprox(kTruth, 1e-12)) << count;
    EXPECT_LT(fit.fre_rms_mm, 1e-10);
  }
}

TEST(FitMarkers, NeverMirrors) {
  transforms::Markers reference_mm = Spread(6);
  transforms::Markers mirrored_mm = reference_mm;
  mirrored_mm.row(0) *= -1.0;
  EXPECT_NEAR(FitMarkers(reference_mm, mirrored_mm).ct_from_reference.linear().determinant(), 1.0,
              1e-12);
  reference_mm.row(2).setZero();  // In a plane both solutions fit: the proper one is taken.
  const MarkerFit fit = FitMarkers(reference_mm, kTruth * reference_mm);
  EXPECT_TRUE(fit.ct_from_reference.isApprox(kTruth, 1e-12));
}

TEST(FitMarkers, RefusesPointsOnALine) {
  transforms::Markers line_mm(3, 4);
  for (int i = 0; i < 4; ++i) line_mm.col(i) = Vector3d(1, 2, 3) * (10.0 * i);
  EXPECT_THAT([&] { FitMarkers(line_mm, line_mm); },
              ThrowsMessage<InputError>(HasSubstr("on a line")));
  EXPECT_THAT([&] { FitMarkers(transforms::Markers::Zero(3, 5), Spread(5)); },
              ThrowsMessage<InputError>(HasSubstr("at the same place in the reference frame")));
  EXPECT_THAT([&] { FitMarkers(Spread(2), Spread(2)); },
              ThrowsMessage<InputError>(HasSubstr("at least 3 points, got 2")));
  line_mm(0, 1) += 1.0;  // A millimetre beside the line is enough for an answer.
  EXPECT_TRUE(FitMarkers(line_mm, kTruth * line_mm).ct_from_reference.isApprox(kTruth, 1e-8));
}

TEST(SpreadMm, IsRmsAlongPrincipalAxes) {
  transforms::Markers markers_mm(3, 4);
  markers_mm << 30, -30, 0, 0, 0, 0, 10, -10, 5, 5, 5, 5;
  EXPECT_TRUE(
      SpreadMm(kTruth * markers_mm).isApprox(Vector3d(std::sqrt(450.0), std::sqrt(50.0), 0), 1e-6));
}

// FRE and TRE formulas against a simulation of 20000 registrations.
TEST(ExpectedTre, AgreesWithSimulation) {
  constexpr int kTrials = 20000;
  constexpr double kFleMm = 1.0;
  for (const int count : {4, 6, 12}) {
    const transforms::Markers markers_mm = Spread(count, 40 + count);
    const Vector3d targets_mm[] = {markers_mm.rowwise().mean(), {150, 20, -60}, {-20, 90, 200}};
    double fre2 = 0.0;
    double tre2[3] = {};
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (int trial = 0; trial < kTrials; ++trial) {
      const MarkerFit fit = FitMarkers(markers_mm, Noisy(markers_mm, kFleMm, trial));
      fre2 += fit.fre_rms_mm * fit.fre_rms_mm / kTrials;
      for (int t = 0; t < 3; ++t) {
        const Vector3d error_mm = fit.ct_from_reference * targets_mm[t] - targets_mm[t];
        tre2[t] += error_mm.squaredNorm() / kTrials;
        if (t == 1) covariance += error_mm * error_mm.transpose() / kTrials;
      }
    }
    EXPECT_NEAR(FleFromFreMm(std::sqrt(fre2), count) / kFleMm, 1.0, 0.01) << count << " markers";
    for (int t = 0; t < 3; ++t) {
      const double expected_mm = ExpectedTre(markers_mm, kFleMm, targets_mm[t]).rms_mm;
      EXPECT_NEAR(std::sqrt(tre2[t]) / expected_mm, 1.0, 0.03) << count << " markers, target " << t;
    }
    const Eigen::Matrix3d expected = ExpectedTre(markers_mm, kFleMm, targets_mm[1]).covariance_mm2;
    EXPECT_LT((covariance - expected).norm() / expected.norm(), 0.06) << count << " markers";
  }
}

TEST(ExpectedTre, IsTheClosedFormOfFitzpatrick) {
  transforms::Markers markers_mm(3, 4);  // Principal axes x, y, z; the mean is the origin.
  markers_mm << 30, -30, 0, 0, 0, 0, 10, -10, 4, 4, -4, -4;
  const double f2[3] = {50 + 16, 450 + 16, 450 + 50};
  const Vector3d target_mm(7, -20, 55);
  const double d2[3] = {400 + 3025, 49 + 3025, 49 + 400};
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += d2[k] / f2[k];
  const TreEstimate tre = ExpectedTre(markers_mm, 0.6, target_mm);
  EXPECT_NEAR(tre.rms_mm, 0.6 * std::sqrt((1 + sum / 3) / 4), 1e-12);
  EXPECT_NEAR(tre.covariance_mm2.trace(), tre.rms_mm * tre.rms_mm, 1e-12);
  EXPECT_NEAR(ExpectedTre(markers_mm, 0.6, Vector3d::Zero()).rms_mm, 0.6 / 2, 1e-12);
}

TEST(FindOutliers, NamesTheWrongPointsAndWhatIsLeft) {
  int accused_wrongly = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const transforms::Markers reference_mm = Spread(8, seed);
    transforms::Markers ct_mm = Noisy(kTruth * reference_mm, 0.5, seed);
    ct_mm.col(3) += Vector3d(4, -5, 3);
    ct_mm.col(6) += Vector3d(0, 9, -9);
    const auto outliers = FindOutliers(reference_mm, ct_mm);
    ASSERT_GE(outliers.size(), 2U) << seed;
    accused_wrongly += outliers.size() > 2;
    EXPECT_EQ(outliers[0].marker, 6);
    EXPECT_EQ(outliers[1].marker, 3);
    EXPECT_LT(outliers[1].evidence.fre_without_mm, 1.0);
    EXPECT_NEAR(outliers[0].evidence.predicted_error_mm, 12.7, 5.0);
  }
  EXPECT_LE(accused_wrongly, 2);  // One in a hundred, by the significance asked for.
}

TEST(FindOutliers, AccusesGoodPointsAsRarelyAsItSays) {
  constexpr int kTrials = 2000;
  int accused = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const transforms::Markers reference_mm = Spread(6);
    accused += !FindOutliers(reference_mm, Noisy(kTruth * reference_mm, 1.0, trial), 0.05).empty();
  }
  // 5 % at most (Bonferroni), and not far below: the test must have its power.
  EXPECT_LT(accused, 0.05 * kTrials + 3 * std::sqrt(0.05 * kTrials));
  EXPECT_GT(accused, 0.025 * kTrials);
}

TEST(FindOutliers, IsQuietWithoutNoiseAndWithFewPoints) {
  EXPECT_THAT(FindOutliers(Spread(7), kTruth * Spread(7)), IsEmpty());
  EXPECT_THAT(FindOutliers(Spread(3), Noisy(kTruth * Spread(3), 5, 0)), IsEmpty());
  transforms::Markers ct_mm = kTruth * Spread(7);
  ct_mm(0, 2) += 1.0;  // One wrong point among exact ones.
  const auto outliers = FindOutliers(Spread(7), ct_mm);
  ASSERT_EQ(outliers.size(), 1U);
  EXPECT_EQ(outliers[0].marker, 2);
  EXPECT_NEAR(outliers[0].evidence.predicted_error_mm, 1.0, 1e-9);
}

TEST(LeaveEachOut, SkipsAPointThatAloneHoldsTheRestOffALine) {
  transforms::Markers markers_mm(3, 4);
  markers_mm << 0, 10, 20, 0, 0, 0, 0, 50, 0, 0, 0, 0;
  const auto results = LeaveEachOut(markers_mm, Noisy(markers_mm, 0.001, 0));
  EXPECT_FALSE(results[3].has_value());
  EXPECT_TRUE(results[0].has_value());
}

transforms::MarkerPairs RigidRegistrationPairs(const transforms::Markers& reference_mm,
                                               const transforms::Markers& ct_mm) {
  transforms::MarkerPairs pairs{{}, reference_mm, ct_mm, {}};
  for (Eigen::Index i = 0; i < ct_mm.cols(); ++i) pairs.names.push_back("m" + std::to_string(i));
  return pairs;
}

TEST(CommonMistakes, AreRecognised) {
  const transforms::Markers reference_mm = Spread(6);
  const transforms::Markers ct_mm = Noisy(kTruth * reference_mm, 0.5, 1);
  EXPECT_THAT(CommonMistakes(RigidRegistrationPairs(reference_mm, ct_mm)), IsEmpty());
  transforms::Markers exchanged_mm = ct_mm;
  exchanged_mm.col(1).swap(exchanged_mm.col(4));
  EXPECT_THAT(CommonMistakes(RigidRegistrationPairs(reference_mm, exchanged_mm)),
              testing::ElementsAre(HasSubstr("'m1' and 'm4' seem to be exchanged")));
  transforms::Markers mirrored_mm = reference_mm;
  mirrored_mm.row(1) *= -1.0;
  EXPECT_THAT(CommonMistakes(RigidRegistrationPairs(mirrored_mm, ct_mm)),
              testing::ElementsAre(HasSubstr("mirror image")));
  EXPECT_THAT(CommonMistakes(RigidRegistrationPairs(reference_mm / 1000.0 * 25.4, ct_mm)),
              testing::ElementsAre(HasSubstr("are both files in mm?")));
}

TEST(RequireSameShape, RefusesMirrorImagesAndOtherUnits) {
  const transforms::Markers reference_mm = Spread(6);
  const transforms::Markers ct_mm = Noisy(kTruth * reference_mm, 0.5, 1);
  EXPECT_NO_THROW(RequireSameShape(RigidRegistrationPairs(reference_mm, ct_mm)));
  transforms::Markers mirrored_mm = reference_mm;
  mirrored_mm.row(1) *= -1.0;
  EXPECT_THROW(RequireSameShape(RigidRegistrationPairs(mirrored_mm, ct_mm)), NoAnswerError);
  EXPECT_THROW(RequireSameShape(RigidRegistrationPairs(reference_mm / 1000.0, ct_mm)), InputError);
}

}  // namespace
}  // namespace acus::registration
