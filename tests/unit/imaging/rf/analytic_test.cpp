#include "acus/imaging/rf/analytic.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::rf {
namespace {

constexpr int kSamples = 256;
constexpr double kSamplingMhz = 40.0;

/// A tone of a whole number of cycles in the trace, over a constant.
ChannelData Tone(int cycles, double phase_rad, float constant) {
  ChannelData data;
  data.samples = kSamples;
  data.elements = data.transmits = 1;
  data.sampling_mhz = kSamplingMhz;
  for (int n = 0; n < kSamples; ++n) {
    data.values.push_back(
        constant +
        static_cast<float>(std::cos(2.0 * std::numbers::pi * cycles * n / kSamples + phase_rad)));
  }
  return data;
}

// The analytic signal of a cosine turns at its frequency with amplitude 1, up to half the sampling
// rate; lowered by a carrier, at the difference of both.
TEST(BasebandOf, OfAToneTurnsAtTheDifferenceToTheCarrier) {
  constexpr int kCarrierCycles = 40;
  const double carrier_mhz = kCarrierCycles * kSamplingMhz / kSamples;
  for (const int cycles : {1, 17, kCarrierCycles, 63, 100, 127}) {
    for (const int oversampling : {1, 3}) {
      const Baseband baseband = BasebandOf(Tone(cycles, 0.3, 5.0F), carrier_mhz, oversampling, 1);
      ASSERT_EQ(baseband.samples, kSamples * oversampling);
      for (int n = 0; n < baseband.samples; ++n) {
        const double turned =
            2.0 * std::numbers::pi * (cycles - kCarrierCycles) * n / baseband.samples + 0.3;
        const std::complex<float> expected(std::polar(1.0, turned));
        ASSERT_LT(std::abs(baseband.values[static_cast<std::size_t>(n)] - expected), 1e-5)
            << cycles << " cycles, sample " << n << " of " << baseband.samples;
      }
    }
  }
}

// Sampled below twice its frequency, a tone appears folded; its band is given by the carrier.
TEST(BasebandOf, OfABandpassSampledToneTurnsAtItsTrueFrequency) {
  for (const auto& [carrier_cycles, cycles] :
       {std::pair{190, 150}, {190, 190}, {190, 240}, {320, 270}, {320, 350}, {450, 400}}) {
    ChannelData tone = Tone(cycles, 0.3, 5.0F);
    const double carrier_mhz = carrier_cycles * kSamplingMhz / kSamples;
    EXPECT_THROW(BasebandOf(tone, carrier_mhz, 1, 1), InputError);
    tone.is_bandpass_sampled = true;
    for (const int oversampling : {1, 3}) {
      const Baseband baseband = BasebandOf(tone, carrier_mhz, oversampling, 1);
      for (int n = 0; n < baseband.samples; ++n) {
        const double turned =
            2.0 * std::numbers::pi * (cycles - carrier_cycles) * n / baseband.samples + 0.3;
        const std::complex<float> expected(std::polar(1.0, turned));
        ASSERT_LT(std::abs(baseband.values[static_cast<std::size_t>(n)] - expected), 2e-5)
            << cycles << " cycles, sample " << n << " of " << baseband.samples;
      }
    }
  }
}

TEST(BasebandOf, RefusesABandAcrossTheFold) {
  ChannelData tone = Tone(40, 0.0, 0.0F);
  tone.is_bandpass_sampled = true;
  for (const double half_rates : {1.0, 1.05, 1.95, 2.0, 3.08, 1e9}) {
    EXPECT_THROW(BasebandOf(tone, 20.0 * half_rates, 1, 1), InputError) << half_rates;
  }
  EXPECT_NO_THROW(BasebandOf(tone, 30.0, 1, 1));
}

TEST(BasebandOf, RefusesWhatIsOutOfRange) {
  const ChannelData tone = Tone(40, 0.0, 0.0F);
  for (const int oversampling : {0, 17}) {
    EXPECT_THROW(BasebandOf(tone, 5.0, oversampling, 1), InputError) << oversampling;
  }
  EXPECT_NO_THROW(BasebandOf(tone, 5.0, 16, 1));
  for (const double carrier_mhz : {0.0, 20.0, -1.0}) {
    EXPECT_THROW(BasebandOf(tone, carrier_mhz, 1, 1), InputError) << carrier_mhz;
  }
}

}  // namespace
}  // namespace acus::rf
