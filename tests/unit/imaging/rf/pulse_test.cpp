#include "acus/imaging/rf/pulse.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/imaging/rf/pulse_table.h"

namespace acus::rf {
namespace {

TEST(Pulse, FallsToHalfAtTheEdgesOfItsBand) {
  const Pulse pulse{5.0, 0.6, 0.0};
  EXPECT_DOUBLE_EQ(pulse.SpectrumAt(5.0), 1.0);
  EXPECT_NEAR(pulse.SpectrumAt(3.5), 0.5, 1e-12);
  EXPECT_NEAR(pulse.SpectrumAt(6.5), 0.5, 1e-12);
  EXPECT_NEAR((Pulse{5.0, 1.5, 2.0}).SpectrumAt(7.5), 0.0, 1e-12);  // First null of two cycles.
}

TEST(Pulse, AttenuationIsInDecibels) {
  // 0.5 dB/(cm MHz) over 10 cm at 5 MHz: 25 dB.
  EXPECT_NEAR(std::exp(-5.0 * NeperPerMhz(0.5, 100.0)), std::pow(10.0, -25.0 / 20.0), 1e-12);
}

/// Attenuation of the sampled spectrum against the closed form of a Gaussian.
TEST(PulseTable, AttenuatesAGaussianAsTheClosedFormSays) {
  const Pulse pulse{5.0, 0.4, 0.0};
  const PulseTable table(pulse, {.sampling_mhz = 40.0,
                                 .attenuation_db_per_cm_mhz = 0.5,
                                 .longest_path_mm = 200.0,
                                 .half_length_us = 1.6});
  for (const double path_mm : {2.0, 50.0, 102.0, 198.0}) {
    const int band = table.BandOf(path_mm);
    const double b = NeperPerMhz(0.5, table.PathOf(band));
    const AttenuatedGaussian expected = AttenuateGaussian(5.0, pulse.SigmaMhz(), b);
    EXPECT_NEAR(table.FrequencyOf(band), expected.frequency_mhz, 0.01) << path_mm;
    const double peak = std::abs(table.Envelope(band, 0)[64]);  // 64 / 40 MHz - 1.6 us = 0.
    EXPECT_NEAR(peak / expected.gain, 1.0, 0.01) << path_mm;
    // The carrier turns by the shift.
    const auto& envelope = table.Envelope(band, 0);
    const double turn = std::arg(envelope[65] * std::conj(envelope[64]));
    const double shift_mhz = turn * 40.0 / (2.0 * 3.14159265358979);
    EXPECT_NEAR(shift_mhz, expected.frequency_mhz - 5.0, 0.01) << path_mm;
  }
}

}  // namespace
}  // namespace acus::rf
