#include "acus/physics/fluid/lumen.h"

#include <gtest/gtest.h>

namespace acus::fluid {
namespace {

constexpr double kTwentyCmH2OKpa = 1.96133;

// Poiseuille in SI units by hand: 90 mm, 1 mPa s, 20 cmH2O.
TEST(Lumen, FlowsByGaugeAreThoseOfHagenAndPoiseuille) {
  const struct {
    double bore_mm, ml_per_min;
  } rows[] = {{0.413, 0.9334}, {0.260, 0.1466}, {0.210, 0.06239}, {0.603, 4.2416}};
  for (const auto& row : rows) {
    const LumenResistance r =
        ResistanceOf({.inner_diameter_mm = row.bore_mm, .length_mm = 90.0}, {1.0, 1000.0}, 0.0);
    EXPECT_NEAR(60.0 * kTwentyCmH2OKpa / r.linear_kpa_s_per_ml, row.ml_per_min,
                0.002 * row.ml_per_min)
        << row.bore_mm;
  }
}

TEST(Lumen, LossesAtTheEndsAreTheKineticEnergyTimesTheirFactor) {
  // 1 ml/s through 1 mm: 1.273 m/s, 810.6 Pa.
  const LumenResistance r =
      ResistanceOf({.inner_diameter_mm = 1.0, .length_mm = 90.0}, {1.0, 1000.0}, 2.16);
  EXPECT_NEAR(r.quadratic_kpa_s2_per_ml2, 2.16 * 0.8106, 1e-4);
}

TEST(Lumen, FlowIsTheInverseOfPressure) {
  const LumenResistance r =
      ResistanceOf({.inner_diameter_mm = 1.2, .length_mm = 80.0}, {0.7, 1000.0});
  for (const double flow : {-3.0, -1e-3, 0.0, 1e-9, 0.5, 20.0}) {
    EXPECT_NEAR(r.FlowMlPerS(r.PressureKpa(flow)), flow, 1e-12 * (1.0 + std::abs(flow)));
  }
}

TEST(Lumen, ATaperedNeedleIsTwoInSeries) {
  const Fluid saline{1.0, 1000.0};
  const Lumen tapered{.inner_diameter_mm = 0.46,
                      .length_mm = 90.0,
                      .tip_inner_diameter_mm = 0.3,
                      .tip_length_mm = 10.0};
  const double wide =
      ResistanceOf({.inner_diameter_mm = 0.46, .length_mm = 80.0}, saline).linear_kpa_s_per_ml;
  const double narrow =
      ResistanceOf({.inner_diameter_mm = 0.3, .length_mm = 10.0}, saline).linear_kpa_s_per_ml;
  EXPECT_NEAR(ResistanceOf(tapered, saline).linear_kpa_s_per_ml, wide + narrow, 1e-9);
  EXPECT_NEAR(tapered.VolumeMl(), 1e-3 * (0.166190 * 80.0 + 0.0706858 * 10.0), 1e-7);
}

}  // namespace
}  // namespace acus::fluid
