// Fits of the 20 public insertions into human liver (de Jong & Dankelman 2017).
#include <cmath>
#include <gtest/gtest.h>

#include "fitting/curve_fit.h"
#include "math/statistics.h"
#include "support/shared_data.h"

namespace acus::fitting {
namespace {

using forces::ReadForceCurve;

std::vector<std::filesystem::path> Recordings() {
  std::vector<std::filesystem::path> folders;
  if (const auto root = testing_support::SharedData("forces/human_liver")) {
    for (int i = 0; i < 40; i += 2) folders.push_back(*root / ("Data" + std::to_string(i)));
  }
  return folders;
}

/// Mean force while the needle is drawn back through depth +- 1 mm.
double RetractionForceN(const ForceCurve& curve, const CurvePhases& phases, double depth_mm) {
  std::vector<double> force;
  for (std::size_t i = phases.retract.begin; i < phases.retract.end; ++i) {
    if (std::abs(curve.depth_mm[i] - depth_mm) < 1.0) force.push_back(curve.force_n[i]);
  }
  return math::Mean(force);
}

TEST(HumanLiver, EveryRecordingHasItsPhasesAndAUsableFit) {
  const auto folders = Recordings();
  if (folders.empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  for (const auto& folder : folders) {
    SCOPED_TRACE(folder.filename().string());
    const ForceCurve curve = ReadForceCurve(folder);
    const PunctureCurveFit fit = FitPunctureCurve(curve);
    ASSERT_TRUE(fit.converged) << fit.message;

    // As described with the data: 5 mm/s in to 85 mm, about a minute of hold, out again.
    const CurvePhases& phases = fit.phases;
    EXPECT_NEAR(phases.advance_mm_per_s, 5.0, 0.1);
    EXPECT_NEAR(curve.depth_mm[phases.hold.begin], 85.0, 1.0);
    const double hold_s = curve.time_s[phases.hold.end] - curve.time_s[phases.hold.begin];
    EXPECT_TRUE(hold_s > 54.0 && hold_s < 63.0) << hold_s;
    EXPECT_TRUE(fit.starts_in_tissue);
    EXPECT_NEAR(fit.offset_n->value, 0.0, 0.01);
    // At rest the sensor has a standard deviation of 0.005 N; the drive's vibration adds to it.
    EXPECT_TRUE(phases.noise_n > 0.004 && phases.noise_n < 0.008) << phases.noise_n;

    // The law leaves less than a fifth of the rise's height (0.02 N at the smallest).
    EXPECT_GT(fit.puncture_n->low, 0.0);
    EXPECT_LT(fit.puncture_n->value, 3.5);
    EXPECT_LT(fit.rise_rms_n, std::max(0.02, 0.18 * fit.puncture_n->value));
    EXPECT_GE(fit.a1_n_per_mm->value, 0.0);
    EXPECT_GE(fit.a2_n_per_mm2->value, 0.0);

    // Friction against plain means at two depths.
    const double plain_n_per_mm =
        (RetractionForceN(curve, phases, 15.0) - RetractionForceN(curve, phases, 60.0)) / 45.0;
    EXPECT_NEAR(fit.friction_n_per_mm->value, plain_n_per_mm, 0.3 * plain_n_per_mm);

    // Half of the force relaxes within seconds.
    ASSERT_TRUE(fit.relaxation_fraction.has_value());
    EXPECT_TRUE(fit.relaxation_fraction->value > 0.35 && fit.relaxation_fraction->value < 0.7);
    EXPECT_TRUE(fit.relaxation_time_s->value > 0.3 && fit.relaxation_time_s->value < 3.0);
  }
}

TEST(HumanLiver, FitsTheSameBitsAgain) {
  const auto folders = Recordings();
  if (folders.empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  const ForceCurve curve = ReadForceCurve(folders.front());
  const auto a = FitPunctureCurve(curve).Estimates();
  const auto b = FitPunctureCurve(curve).Estimates();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].second.value, b[i].second.value) << a[i].first;
    EXPECT_EQ(a[i].second.low, b[i].second.low) << a[i].first;
  }
}

}  // namespace
}  // namespace acus::fitting
