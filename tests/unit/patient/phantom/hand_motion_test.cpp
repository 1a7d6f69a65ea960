#include "acus/patient/phantom/hands/hand_motion.h"

#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::phantom {
namespace {

TEST(MinimumJerk, StartsAndEndsAtRestAndIsSymmetric) {
  EXPECT_EQ(MinimumJerk(-1.0), 0.0);
  EXPECT_EQ(MinimumJerk(0.0), 0.0);
  EXPECT_EQ(MinimumJerk(1.0), 1.0);
  EXPECT_EQ(MinimumJerk(2.0), 1.0);
  for (double t = 0.0; t <= 1.0; t += 0.05) {
    EXPECT_NEAR(MinimumJerk(t) + MinimumJerk(1.0 - t), 1.0, 1e-12);
  }
  // Speed and acceleration vanish at the ends: the start goes with the third power of time.
  EXPECT_NEAR(MinimumJerk(1e-3) / 1e-9, 10.0, 0.1);
}

TEST(StrokeDuration, KeepsTheHighestSpeed) {
  const double duration = StrokeDurationS(60.0, 20.0);
  double fastest = 0.0;
  constexpr double kStep = 1e-4;
  for (double t = 0.0; t < 1.0; t += kStep) {
    fastest =
        std::max(fastest, 60.0 * (MinimumJerk(t + kStep) - MinimumJerk(t)) / (kStep * duration));
  }
  EXPECT_NEAR(fastest, 20.0, 0.01);
  EXPECT_EQ(StrokeDurationS(0.0, 20.0), 0.0);
  EXPECT_EQ(StrokeDurationS(0.1, 20.0), 0.35);
  EXPECT_EQ(StrokeDurationS(-60.0, 20.0), duration);
}

/// Power of a signal of 40 s, sampled at 100 Hz, at one frequency.
double PowerAt(const BandNoise& noise, double hz) {
  std::complex<double> sum = 0.0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const double t = i / 100.0;
    // Hann window: the sides of a line must not look like power out of the band.
    const double window = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * i / kSamples);
    sum += window * noise.At(t) * std::polar(1.0, -2.0 * std::numbers::pi * hz * t);
  }
  return std::norm(sum);
}

TEST(BandNoise, HasItsRootMeanSquareAndPowerInItsBandOnly) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const BandNoise noise(seed, "test", 8.0, 12.0, 0.25);
    double squares = 0.0;
    constexpr int kSamples = 20'000;
    for (int i = 0; i < kSamples; ++i) squares += std::pow(noise.At(0.005 * i), 2);
    EXPECT_NEAR(std::sqrt(squares / kSamples), 0.25, 0.01);
    double inside = 0.0, outside = 0.0, strongest = 0.0, strongest_hz = 0.0;
    for (double hz = 0.5; hz < 40.0; hz += 0.1) {
      const double power = PowerAt(noise, hz);
      (hz > 7.9 && hz < 12.1 ? inside : outside) += power;
      if (power > strongest) strongest_hz = hz, strongest = power;
    }
    EXPECT_LT(outside, 1e-4 * inside);
    EXPECT_GE(strongest_hz, 8.0);
    EXPECT_LE(strongest_hz, 12.0);
  }
}

TEST(BandNoise, BelongsToItsSeedAndName) {
  const BandNoise a(1, "x", 8, 12, 1), again(1, "x", 8, 12, 1), b(1, "y", 8, 12, 1);
  EXPECT_EQ(a.At(0.37), again.At(0.37));
  EXPECT_NE(a.At(0.37), b.At(0.37));
}

}  // namespace
}  // namespace acus::phantom
