#include "acus/physics/fluid/tissue_spread.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::fluid {
namespace {

constexpr double kResistance = 30.0;
constexpr double kTimeS = 0.5;

/// Constant flow from t = 0 into a sphere in infinite tissue (Carslaw & Jaeger 1959, 9.10).
double ExactKpa(double flow_ml_per_s, double time_s) {
  const double x = time_s / kTimeS;
  return kResistance * flow_ml_per_s * (1.0 - std::exp(x) * std::erfc(std::sqrt(x)));
}

double LargestError(int num_shells, double dt_s, double until_s) {
  const TissueSpread spread(kResistance, kTimeS, num_shells);
  TissueSpread::State state;
  double worst = 0.0;
  const int num = static_cast<int>(std::lround(until_s / dt_s));
  for (int i = 1; i <= num; ++i) {
    spread.Advance(state, 0.1, dt_s);
    const double time_s = dt_s * i;
    if (time_s < 0.02) continue;
    worst = std::max(worst, std::abs(state.kpa[0] - ExactKpa(0.1, time_s)));
  }
  return worst / (kResistance * 0.1);
}

TEST(TissueSpread, SteadyPressureIsTheDarcyResistanceTimesFlow) {
  const TissueSpread spread(kResistance, kTimeS, 8);
  TissueSpread::State state;
  spread.Advance(state, 0.1, 1e12);
  EXPECT_NEAR(state.kpa[0], 3.0, 1e-6);
}

// Of the steady pressure; the time constant of the page is where the closed form has 57 % of it.
TEST(TissueSpread, RisesAsTheClosedFormOfASphere) {
  EXPECT_NEAR(ExactKpa(1.0, kTimeS) / kResistance, 0.5724, 1e-4);
  EXPECT_LT(LargestError(16, 1e-3, 10.0), 0.012);
  EXPECT_LT(LargestError(8, 1e-3, 10.0), 0.04);
  EXPECT_LT(LargestError(16, 1e-3, 10.0), 0.5 * LargestError(8, 1e-3, 10.0));
}

// Darcy's law in steady radial flow, integrated from the cavity to infinity.
TEST(TissueSpread, ResistancesOfSphereAndHalfSpaceAreDarcys) {
  const Fluid fluid{0.7, 1000.0};
  const double k_m2 = 3e-14;
  for (const double angle : {4.0 * std::numbers::pi, 2.0 * std::numbers::pi}) {
    double pa_s_per_m3 = 0.0;
    for (double r_m = 1e-3; r_m < 10.0; r_m *= 1.001) {
      const double dr_m = 0.001 * r_m;
      const double middle_m = r_m + 0.5 * dr_m;
      pa_s_per_m3 += 0.7e-3 / (k_m2 * angle * middle_m * middle_m) * dr_m;
    }
    EXPECT_NEAR(DarcyKpaSPerMl(fluid, k_m2, 1.0, angle), 1e-9 * pa_s_per_m3,
                1e-3 * 1e-9 * pa_s_per_m3);
  }
  // 1 mm, 3e-14 m^2, 100 kPa, 0.7 mPa s: D = 4.286e-6 m^2/s.
  EXPECT_NEAR(DarcyTimeS(fluid, k_m2, 100.0, 1.0), 0.23333, 1e-4);
}

TEST(TissueSpread, StoresWhatEntersUntilItReachesFarTissue) {
  const TissueSpread spread(kResistance, kTimeS, 16);
  TissueSpread::State state;
  for (int i = 0; i < 50; ++i) spread.Advance(state, 0.1, 1e-3);
  EXPECT_NEAR(spread.StoredMl(state), 0.1 * 0.05, 1e-9);
}

TEST(TissueSpread, ResponseForetellsTheStep) {
  const TissueSpread spread(kResistance, kTimeS, 8);
  TissueSpread::State state;
  for (int i = 0; i < 20; ++i) {
    const double flow = 0.1 * std::sin(i);
    const TissueSpread::Response response = spread.ResponseOf(state, 2e-3);
    spread.Advance(state, flow, 2e-3);
    EXPECT_NEAR(state.kpa[0], response.free_kpa + response.kpa_s_per_ml * flow, 1e-12);
  }
}

}  // namespace
}  // namespace acus::fluid
