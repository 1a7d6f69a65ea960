#include "acus/imaging/acoustics/beam_width.h"

#include <cmath>
#include <complex>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::acoustics {
namespace {

constexpr double kPi = std::numbers::pi;

Probe Linear() {
  Probe probe = DefaultProbe();
  probe.width_mm = 40;
  probe.frequency_mhz = 7.7;  // 0.2 mm.
  probe.focus_mm = 30;
  probe.f_number = 2;
  probe.elevation_aperture_mm = 4;
  probe.elevation_focus_mm = 20;
  return probe;
}

/// Full width at half maximum of an even function that falls from its middle.
double MeasuredFwhm(const std::function<double(double)>& f, double reach) {
  const double half = 0.5 * f(0.0);
  double x = 0.0;
  while (f(x) > half && x < reach) x += 1e-4 * reach;
  return 2.0 * x;
}

/// Huygens: the amplitude that a line of sources of the given weights, focused by their phases,
/// makes at (x, depth). Full distances, no approximation of their differences.
double Huygens(double aperture_mm, double focus_mm, double depth_mm, double wavelength_mm, double x,
               const std::function<double(double)>& weight) {
  std::complex<double> sum = 0.0;
  constexpr int kSources = 800;
  for (int n = 0; n < kSources; ++n) {
    const double s = aperture_mm * ((n + 0.5) / kSources - 0.5);
    const double path = std::hypot(x - s, depth_mm) - std::hypot(s, focus_mm);
    sum += weight(s) * std::polar(1.0, 2.0 * kPi * path / wavelength_mm);
  }
  return std::abs(sum);
}

TEST(BeamWidth, APulseIsAsLongAsItsSpectrumIsNarrow) {
  const Probe probe = Linear();
  // The spectrum falls to half at the edges of the band; its Fourier integral is the envelope.
  const double half_band = 0.5 * probe.fractional_bandwidth * probe.frequency_mhz;
  const auto envelope = [&](double depth_mm) {
    const double time_us = 2.0 * depth_mm / 1.54;
    double sum = 0.0;
    for (double f = -6 * half_band; f <= 6 * half_band; f += 0.01 * half_band) {
      sum += std::exp2(-(f / half_band) * (f / half_band)) * std::cos(2 * kPi * f * time_us);
    }
    return sum;
  };
  EXPECT_NEAR(AxialFwhmMm(probe), MeasuredFwhm(envelope, 2.0), 2e-3 * AxialFwhmMm(probe) + 4e-4);
}

TEST(BeamWidth, InTheFocusItIsThatOfTheFullAperture) {
  const double lambda = 0.2;
  const auto amplitude = [&](double x) {
    return Huygens(15, 30, 30, lambda, x, [](double) { return 1.0; });
  };
  EXPECT_NEAR(OneWayFwhmMm(15, 30, 30, lambda), MeasuredFwhm(amplitude, 2.0), 0.03 * 0.48);
}

TEST(BeamWidth, BesideTheFocusItIsThatOfTheGaussianApertureOfTheSameWidth) {
  const double lambda = 0.2;
  const double radius_mm = 15 * 1.6651092 / (kPi * 1.2067);
  const auto weight = [&](double s) { return std::exp(-(s * s) / (radius_mm * radius_mm)); };
  for (const double depth_mm : {15.0, 25.0, 30.0, 40.0, 60.0}) {
    const auto amplitude = [&](double x) { return Huygens(60, 60, depth_mm, lambda, x, weight); };
    const double expected = OneWayFwhmMm(15, 60, depth_mm, lambda);
    EXPECT_NEAR(expected, MeasuredFwhm(amplitude, 10.0), 0.02 * expected) << depth_mm;
  }
}

TEST(BeamWidth, ThereAndBackIsTheProductOfBothWays) {
  const Probe probe = Linear();
  // In the focus both ways have the aperture focus / F: sinc^2 is half at 0.44295.
  const double sinc2 = 2.0 * 0.44295 * WavelengthMm(probe) * probe.f_number;
  EXPECT_NEAR(LateralFwhmMm(probe, probe.focus_mm), sinc2, 0.05 * sinc2);
  EXPECT_NEAR(ElevationFwhmMm(probe, 20.0), 2.0 * 0.44295 * WavelengthMm(probe) * 20.0 / 4.0,
              0.05 * 0.886);
}

TEST(BeamWidth, IsNarrowestNearTheFocusAndWidensOnBothSides) {
  const Probe probe = Linear();
  EXPECT_GT(LateralFwhmMm(probe, 60.0), LateralFwhmMm(probe, 30.0));
  EXPECT_GT(ElevationFwhmMm(probe, 5.0), 1.5 * ElevationFwhmMm(probe, 20.0));
  EXPECT_GT(ElevationFwhmMm(probe, 60.0), 2.0 * ElevationFwhmMm(probe, 20.0));
}

TEST(BeamWidth, TheApertureGrowsUntilAllElementsWork) {
  Probe probe = Linear();
  EXPECT_DOUBLE_EQ(TransmitApertureMm(probe), 15.0);
  EXPECT_DOUBLE_EQ(ReceiveApertureMm(probe, 20.0), 10.0);
  EXPECT_DOUBLE_EQ(ReceiveApertureMm(probe, 300.0), 40.0);
  EXPECT_DOUBLE_EQ(ReceiveApertureMm(probe, 0.0), 2.0 * 40.0 / 128.0);
  probe.elements = 64;
  probe.pitch_mm = 0.3;
  EXPECT_DOUBLE_EQ(ReceiveApertureMm(probe, 300.0), 19.2);
}

TEST(BeamWidth, IsPositiveAndFiniteForEveryDepthOfEveryPreset) {
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(ACUS_SOURCE_DIR) / "configs/probes")) {
    const Probe probe = ReadProbe(entry.path());
    for (double depth_mm = 0.0; depth_mm <= probe.depth_mm; depth_mm += 1.0) {
      for (const double fwhm : {LateralFwhmMm(probe, depth_mm), ElevationFwhmMm(probe, depth_mm)}) {
        EXPECT_GT(fwhm, 0.05) << entry.path() << depth_mm;
        EXPECT_LT(fwhm, 30.0) << entry.path() << depth_mm;
      }
    }
    EXPECT_GT(AxialFwhmMm(probe), 0.02);
    EXPECT_LT(AxialFwhmMm(probe), 1.0);
  }
}

}  // namespace
}  // namespace acus::acoustics
