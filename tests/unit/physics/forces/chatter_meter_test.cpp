#include "acus/physics/forces/path/chatter_meter.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::forces {
namespace {

constexpr double kStepS = 1e-3;

/// A sine of 1 N for 10 s, of which the last 9 s count.
double ChatterOfSine(double hz) {
  ChatterMeter meter;
  for (int n = 0; n < 10000; ++n) {
    const double force_n = std::sin(2.0 * std::numbers::pi * hz * n * kStepS);
    meter.Add(kStepS, {0.6 * force_n, 0.0, 0.8 * force_n}, n >= 1000);
  }
  return meter.RmsN();
}

TEST(ChatterMeter, IsAHighPassOfFirstOrder) {
  for (const double hz : {1.0, 10.0, 30.0, 100.0}) {
    const double exact = std::sqrt(0.5) * hz / std::hypot(hz, ChatterMeter::kHz);
    // The filter is of samples of 1 ms.
    EXPECT_NEAR(ChatterOfSine(hz), exact, 0.12 * exact) << hz;
  }
}

TEST(ChatterMeter, ASteadyForceDoesNotChatterAndNothingIsNothing) {
  ChatterMeter meter;
  EXPECT_EQ(meter.RmsN(), 0.0);
  for (int n = 0; n < 100; ++n) meter.Add(kStepS, {0, 0, 3}, true);
  EXPECT_EQ(meter.RmsN(), 0.0);
  EXPECT_EQ(meter.slow_n(), Eigen::Vector3d(0, 0, 3));
  meter.Add(kStepS, {0, 0, 9}, false);
  EXPECT_EQ(meter.RmsN(), 0.0);
}

}  // namespace
}  // namespace acus::forces
