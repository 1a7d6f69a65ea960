#include "acus/imaging/ultrasound/columns/echo.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

constexpr double kStepMm = 0.2;
constexpr int kLines = 40;
constexpr int kSamples = 200;

acoustics::ScanGrid Grid() {
  return acoustics::ScanGridOf(image::ImageGeometry{.width_px = kLines,
                                                    .height_px = kSamples,
                                                    .lateral_mm_per_px = 0.3,
                                                    .axial_mm_per_px = kStepMm});
}

volume::Geometry AnyGeometry() {
  volume::Geometry g;
  g.size = {10, 10, 10};
  return g;
}

/// Impedance 1.5 (1 + HU / 1000): easy to compute by hand; nothing boosted, no gel.
BModeOptions Plain() {
  BModeOptions options;
  options.impedance_mrayl = {{-999, 0.0015}, {4000, 7.5}};
  options.needle_reflection = 1.0;
  return options;
}

double Impedance(double hu) {
  return 1.5 * (1.0 + hu / 1000.0);
}
double Reflection(double hu0, double hu1) {
  const double a = (Impedance(hu1) - Impedance(hu0)) / (Impedance(hu1) + Impedance(hu0));
  return a * a;
}

/// Traces lines whose HU depend on line and sample; row(k)[line] of the result is the echo.
template <typename Hu>
slicing::BeamImage Trace(const BModeOptions& options, const Hu& hu_at, int num_threads = 1) {
  const acoustics::ScanGrid grid = Grid();
  EchoTracer tracer(grid, /*frequency_mhz=*/5.0, options, AnyGeometry());
  slicing::BeamLines lines;
  for (int a = 0; a < 3; ++a) {
    lines.start[a].Reserve(48);
    lines.step[a].Reserve(48);
    for (int l = 0; l < 48; ++l)
      lines.start[a].data()[l] = static_cast<float>(l * (0.3137 + 0.1 * a));
    std::fill_n(lines.step[a].data(), 48, 0.2113F - 0.0371F * static_cast<float>(a));
  }
  slicing::BeamImage hu;
  hu.Resize(kLines, kSamples);
  for (int k = 0; k < kSamples; ++k) {
    for (int l = 0; l < 48; ++l)
      hu.row(k)[l] = static_cast<float>(hu_at(std::min(l, kLines - 1), k));
  }
  slicing::BeamImage echo;
  tracer.Trace(lines, slicing::BeamBend(), hu, echo, num_threads);
  return echo;
}

TEST(Echo, TwoHalfSpacesReflectByTheirImpedances) {
  for (const double hu1 : {-150.0, 0.0, 80.0, 400.0, 1500.0}) {
    const slicing::BeamImage echo =
        Trace(Plain(), [&](int, int k) { return k < 100 ? 40.0 : hu1; });
    for (int k = 0; k < kSamples; ++k) {
      const double expected = k == 100 ? Reflection(40.0, hu1) : 0.0;
      EXPECT_NEAR(echo.row(k)[17], expected, 1e-6 + 1e-4 * expected) << hu1 << " HU, sample " << k;
    }
  }
}

TEST(Echo, WhatIsReflectedIsMissingBelowInBothDirections) {
  const double hu[] = {40.0, 300.0, -100.0, 900.0};
  const slicing::BeamImage echo = Trace(Plain(), [&](int, int k) { return hu[k / 50]; });
  double energy = 1.0;
  for (int n = 1; n < 4; ++n) {
    const double r = Reflection(hu[n - 1], hu[n]);
    EXPECT_NEAR(echo.row(50 * n)[5], energy * r, 1e-5 * r) << "interface " << n;
    energy *= (1.0 - r) * (1.0 - r);
  }
}

TEST(Echo, AnInterfaceReflectsTheSameOverASpanOfSamples) {
  BModeOptions options = Plain();
  for (const double span_mm : {0.0, 0.2, 0.4, 0.6, 1.2}) {
    options.interface_span_mm = span_mm;
    const slicing::BeamImage echo =
        Trace(options, [](int, int k) { return k < 100 ? 40.0 : 90.0; });
    double sum = 0.0;
    double centre = 0.0;
    for (int k = 0; k < kSamples; ++k) {
      sum += echo.row(k)[8];
      centre += k * static_cast<double>(echo.row(k)[8]);
    }
    const double expected = Reflection(40.0, 90.0);
    EXPECT_NEAR(sum, expected, 2e-3 * expected) << span_mm;
    EXPECT_NEAR(centre / sum, 99.75, 0.3) << span_mm;  // Between samples 99 and 100.
  }
}

TEST(Echo, AboveTheThresholdTheBeamIsBlocked) {
  BModeOptions options = Plain();
  options.interface_span_mm = 0.8;
  options.shadow_threshold = 0.01;
  options.boosted_reflection = 0.9999;
  const auto plate = [](int, int k) { return k >= 60 && k < 80 ? 700.0 : k < 140 ? 40.0 : 100.0; };
  const slicing::BeamImage echo = Trace(options, plate);
  double front = 0.0;
  double below = 0.0;
  for (int k = 0; k < kSamples; ++k) (k < 70 ? front : below) += echo.row(k)[9];
  EXPECT_GT(front, 0.9);
  // The line begins at the surface; up to there only what a weak interface would give.
  EXPECT_GT(echo.row(60)[9], 0.9);
  EXPECT_LE(echo.row(59)[9], 0.01 / 4);
  EXPECT_LT(below, 1e-8);
  // Just below the threshold nothing happens.
  options.shadow_threshold = 1.001 * Reflection(40.0, 700.0);
  const slicing::BeamImage unboosted = Trace(options, plate);
  EXPECT_NEAR(unboosted.row(60)[9] / unboosted.row(58)[9], 1.0, 0.1);
  EXPECT_GT(unboosted.row(140)[9], 0.5 * Reflection(40.0, 100.0) / 4);
}

TEST(Echo, AThinNeedleLetsAShareOfTheBeamPass) {
  BModeOptions options = Plain();
  options.shadow_threshold = 0.01;
  options.boosted_reflection = 0.9999;
  options.needle_reflection = 0.3;
  const slicing::BeamImage echo = Trace(options, [](int, int k) {
    return k >= 60 && k < 65 ? 4000.0 : k < 140 ? 40.0 : 100.0;
  });
  EXPECT_NEAR(echo.row(60)[3], 0.3, 1e-5);
  // Two surfaces, each there and back.
  EXPECT_NEAR(echo.row(140)[3], std::pow(0.7, 4) * Reflection(40.0, 100.0), 1e-8);
}

TEST(Echo, AttenuationFollowsBeerAndLambertThereAndBack) {
  BModeOptions options = Plain();
  options.attenuation = true;
  options.attenuation_db_per_cm_mhz = {{0, 0.5}, {100, 1.0}};
  // Weak interfaces 1 cm (50 samples) apart, in 40 HU: 0.7 dB/cm/MHz at 5 MHz, twice 1 cm.
  const slicing::BeamImage echo =
      Trace(options, [](int, int k) { return k % 50 == 25 ? 40.5 : 40.0; });
  const double db = 10.0 * std::log10(echo.row(125)[2] / echo.row(75)[2]);
  EXPECT_NEAR(db, -2.0 * 0.7 * 5.0, 0.03);
}

TEST(Echo, TheAngleWeighsByThePowerOfTheCosine) {
  BModeOptions options = Plain();
  options.interface_span_mm = 0.4;
  // A plane of slope dk per line: tan(angle) = dk * 0.2 / 0.3.
  const auto slanted = [](double slope) {
    return [slope](int l, int k) { return 40.0 + std::clamp(k - 60.0 - slope * l, 0.0, 40.0); };
  };
  const slicing::BeamImage flat = Trace(options, slanted(1.5));
  const double cosine = 1.0 / std::sqrt(2.0);
  for (const int exponent : {1, 2}) {
    options.angle_exponent = exponent;
    const slicing::BeamImage weighted = Trace(options, slanted(1.5));
    EXPECT_NEAR(weighted.row(100)[20] / flat.row(100)[20], std::pow(cosine, exponent), 0.01);
    const slicing::BeamImage straight = Trace(options, slanted(0.0));
    options.angle_exponent = 0;
    EXPECT_NEAR(straight.row(80)[20] / Trace(options, slanted(0.0)).row(80)[20], 1.0, 1e-5);
  }
}

TEST(Echo, GelFillsASmallGapAndNotALargeOne) {
  BModeOptions options = Plain();
  options.shadow_threshold = 0.01;
  options.boosted_reflection = 0.9999;
  options.coupling_gap_mm = 2.0;  // 10 samples.
  const auto skin_at = [](int skin) {
    return [skin](int, int k) { return k < skin ? -1000.0 : k < 100 ? 40.0 : 90.0; };
  };
  const double interface = Reflection(40.0, 90.0);
  for (const int skin : {0, 1, 10}) {
    const slicing::BeamImage echo = Trace(options, skin_at(skin));
    EXPECT_NEAR(echo.row(100)[4], interface, 1e-6) << skin;
    EXPECT_EQ(echo.row(skin)[4], 0.0F) << "the matched face of the gel gives no echo";
  }
  for (const int skin : {11, 50}) {
    const slicing::BeamImage echo = Trace(options, skin_at(skin));
    for (int k = 0; k < kSamples; ++k) EXPECT_EQ(echo.row(k)[4], 0.0F) << skin;
  }
}

TEST(Echo, TextureIsExponentiallyDistributedAroundTheTable) {
  BModeOptions options = Plain();
  options.texture = true;
  options.texture_grain_mm = 0.05;  // Finer than samples: each draws anew.
  options.backscatter_db = {{0, -30.0}, {100, -30.0}};
  const slicing::BeamImage echo = Trace(options, [](int, int) { return 50.0; });
  double sum = 0.0;
  double squares = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    for (int l = 0; l < kLines; ++l) {
      sum += echo.row(k)[l];
      squares += static_cast<double>(echo.row(k)[l]) * echo.row(k)[l];
    }
  }
  const double mean = sum / (kSamples * kLines);
  EXPECT_NEAR(mean, 1e-3 * kStepMm, 0.03 * 1e-3 * kStepMm);
  // Standard deviation = mean for the intensity of fully developed speckle.
  EXPECT_NEAR(std::sqrt(squares / (kSamples * kLines) / (mean * mean) - 1.0), 1.0, 0.06);
}

TEST(Echo, AnInactiveStageChangesNoBit) {
  const auto hu = [](int l, int k) { return 40.0 + 60.0 * ((l / 7 + k / 13) % 3); };
  const slicing::BeamImage plain = Trace(Plain(), hu);
  BModeOptions options = Plain();
  options.attenuation = true;
  options.attenuation_db_per_cm_mhz = {{0, 0.0}};
  options.texture = true;
  options.texture_grain_mm = 0.5;
  options.backscatter_db = {{0, -10000.0}};
  const slicing::BeamImage inactive = Trace(options, hu);
  for (int k = 0; k < kSamples; ++k) {
    for (int l = 0; l < kLines; ++l) EXPECT_EQ(plain.row(k)[l], inactive.row(k)[l]);
  }
}

TEST(Echo, CurvesRunThroughTheirKnotsAndAreFlatBeyond) {
  const slicing::kernels::Curve curve = CurveOf({{-100, 1.0}, {0, 2.0}, {50, 0.5}});
  alignas(64) const float hu[16] = {-1000, -100, -50, 0, 25, 50, 4000, 10};
  alignas(64) float out[16];
  slicing::kernels::CurveRow(curve, hu, 16, out);
  const float expected[] = {1.0F, 1.0F, 1.5F, 2.0F, 1.25F, 0.5F, 0.5F, 1.7F};
  for (int n = 0; n < 8; ++n) EXPECT_NEAR(out[n], expected[n], 1e-5) << hu[n] << " HU";
  EXPECT_THROW(CurveOf({}), InputError);
  EXPECT_THROW(CurveOf({{0, 1}, {0, 2}}), InputError);
  EXPECT_THROW(CurveOf({{0, 1}, {-1, 2}}), InputError);
  EXPECT_THROW(CurveOf(std::vector<HuKnot>(17)), InputError);
}

TEST(Echo, RefusesOptionsOutOfRange) {
  const auto make = [](const BModeOptions& o) { EchoTracer(Grid(), 5.0, o, AnyGeometry()); };
  BModeOptions options = Plain();
  for (const int exponent : {-1, 3}) {
    options.angle_exponent = exponent;
    EXPECT_THROW(make(options), InputError);
  }
  options = Plain();
  for (const double share : {0.0, -0.5, 1.01}) {
    options.boosted_reflection = share;
    EXPECT_THROW(make(options), InputError) << share;
    options.boosted_reflection = 1.0;
    options.needle_reflection = share;
    EXPECT_THROW(make(options), InputError) << share;
    options.needle_reflection = 1.0;
  }
  options.texture = true;
  options.backscatter_db = {{0, -40}};
  options.texture_grain_mm = 0.0;
  EXPECT_THROW(make(options), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
