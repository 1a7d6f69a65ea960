// The cry against closed forms: gain of the resonator, pitch, loudness.
#include "acus/data/sound/cry.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <numbers>
#include <span>

namespace acus::sound {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// |A / (1 - B z^-1 - C z^-2)| on the unit circle.
double GainOf(const Formant& formant, double rate_hz, double frequency_hz) {
  const double c = -std::exp(-kTurn * formant.width_hz / rate_hz);
  const double b = 2.0 * std::exp(-0.5 * kTurn * formant.width_hz / rate_hz) *
                   std::cos(kTurn * formant.frequency_hz / rate_hz);
  const std::complex<double> back = std::polar(1.0, -kTurn * frequency_hz / rate_hz);
  return (1.0 - b - c) / std::abs(1.0 - b * back - c * back * back);
}

TEST(Resonator, HasTheGainOfItsTransferFunction) {
  constexpr int kRateHz = 44100;
  const Formant formant{700.0, 130.0};
  for (const double frequency_hz : {100.0, 635.0, 700.0, 765.0, 3000.0}) {
    Resonator resonator(formant, kRateHz);
    double largest = 0.0;
    for (int i = 0; i < kRateHz; ++i) {
      const double y = resonator.Next(std::sin(kTurn * frequency_hz * i / kRateHz));
      if (i > kRateHz / 2) largest = std::max(largest, std::abs(y));
    }
    const double expected = GainOf(formant, kRateHz, frequency_hz);
    EXPECT_NEAR(largest, expected, 0.003 * expected) << frequency_hz;
  }
  // A step settles at 1, and half the width off the power is half that of the peak.
  Resonator resonator(formant, kRateHz);
  double y = 0.0;
  for (int i = 0; i < kRateHz; ++i) y = resonator.Next(1.0);
  EXPECT_NEAR(y, 1.0, 1e-9);
  const double peak = GainOf(formant, kRateHz, 700.0);
  EXPECT_NEAR(std::pow(GainOf(formant, kRateHz, 765.0) / peak, 2), 0.5, 0.05);
}

/// Power of the sound at a frequency.
double PowerAt(const Sound& sound, double frequency_hz) {
  std::complex<double> sum;
  for (std::size_t i = 0; i < sound.samples.size(); ++i) {
    sum += static_cast<double>(sound.samples[i]) *
           std::polar(1.0, -kTurn * frequency_hz * static_cast<double>(i) / sound.rate_hz);
  }
  return std::norm(sum);
}

TEST(Cry, HasItsPitchAndItsPeak) {
  CrySettings settings;
  settings.pitch_hz = {200.0, 200.0, 200.0};
  settings.duration_s = 1.0;
  const Sound sound = Cry(settings);
  EXPECT_EQ(sound.samples.size(), 44100U);
  int largest = 0;
  for (const int sample : sound.samples) largest = std::max(largest, std::abs(sample));
  EXPECT_EQ(largest, std::lround(32767.0 * settings.peak));
  // All power is at multiples of the pitch, most of it near the first formant.
  for (const double frequency_hz : {200.0, 400.0, 600.0, 800.0, 1200.0}) {
    EXPECT_GT(PowerAt(sound, frequency_hz), 200.0 * PowerAt(sound, frequency_hz + 100.0));
  }
  for (const double frequency_hz : {200.0, 400.0, 1000.0, 1600.0, 2600.0}) {
    EXPECT_GT(PowerAt(sound, 600.0) + PowerAt(sound, 800.0), PowerAt(sound, frequency_hz));
  }
}

TEST(Cry, RisesFallsAndEndsSoftly) {
  const CrySettings settings;
  EXPECT_EQ(PitchAt(settings, 0.0), settings.pitch_hz[0]);
  EXPECT_NEAR(PitchAt(settings, settings.duration_s / 3.0), settings.pitch_hz[1], 1e-9);
  EXPECT_EQ(PitchAt(settings, settings.duration_s), settings.pitch_hz[2]);
  EXPECT_NEAR(PitchAt(settings, settings.duration_s / 6.0),
              0.5 * (settings.pitch_hz[0] + settings.pitch_hz[1]), 1e-9);
  EXPECT_NEAR(PitchAt(settings, settings.duration_s * 2.0 / 3.0),
              0.5 * (settings.pitch_hz[1] + settings.pitch_hz[2]), 1e-9);
  const Sound sound = Cry(settings);
  EXPECT_EQ(sound.samples.front(), 0);
  for (std::size_t i = sound.samples.size() - 20; i < sound.samples.size(); ++i) {
    EXPECT_LT(std::abs(sound.samples[i]), 100) << "no click";
  }
  EXPECT_EQ(sound.samples, Cry(settings).samples);
  // It is loud between a tenth and half of its duration.
  const auto loudest = [&](double from, double to) {
    const auto size = static_cast<double>(sound.samples.size());
    int most = 0;
    for (auto i = static_cast<std::size_t>(from * size); i < static_cast<std::size_t>(to * size);
         ++i) {
      most = std::max(most, std::abs(sound.samples[i]));
    }
    return most;
  };
  EXPECT_LT(loudest(0.0, 0.03), 0.6 * loudest(0.1, 0.5));
  EXPECT_LT(loudest(0.95, 1.0), 0.3 * loudest(0.1, 0.5));
  EXPECT_GT(loudest(0.1, 0.2), 0.6 * loudest(0.1, 0.5));
}

/// A voice without a mouth: what the lips radiate, the flow's rate of change.
CrySettings VoiceAlone() {
  CrySettings settings;
  settings.pitch_hz = {200.0, 200.0, 200.0};
  settings.duration_s = 1.0;
  settings.formants.fill({.frequency_hz = 0.0, .width_hz = 1e6});
  return settings;
}

TEST(Cry, TheGlottisClosesFasterThanItOpens) {
  const Sound voice = Cry(VoiceAlone());
  // Rosenberg's pulse B rises by at most 1.5 / 0.40 and falls by at most 2 / 0.16 of itself in a
  // period. It begins and ends at 0: the changes of a period add up to nothing.
  const auto period = std::span(voice.samples).subspan(44 * 220, 221);
  const double steepest = *std::ranges::max_element(period);
  EXPECT_NEAR(*std::ranges::min_element(period) / steepest, -(2.0 / 0.16) / (1.5 / 0.40), 0.1);
  double sum = 0.0, of_sizes = 0.0;
  for (std::size_t i = 44 * 220; i < 44 * 220 + 2205; ++i) {  // Ten periods.
    sum += voice.samples[i];
    of_sizes += std::abs(voice.samples[i]);
  }
  EXPECT_NEAR(sum / of_sizes, 0.0, 0.01);
}

TEST(Cry, IsEvenlyLoudFromATenthToAHalfAndFadesSteadily) {
  const Sound voice = Cry(VoiceAlone());
  const auto rms = [&](double from_s) {  // Over four periods.
    double sum = 0.0;
    const auto begin = static_cast<std::size_t>(44100 * from_s);
    for (std::size_t i = begin; i < begin + 882; ++i) sum += std::pow(voice.samples[i], 2);
    return std::sqrt(sum / 882.0);
  };
  const double full = rms(0.3);
  for (double from_s = 0.10; from_s < 0.48; from_s += 0.02) {
    EXPECT_NEAR(rms(from_s), full, 0.02 * full) << from_s;
  }
  for (double from_s = 0.0; from_s < 0.08; from_s += 0.02) {
    EXPECT_LT(rms(from_s), rms(from_s + 0.02)) << from_s;
  }
  for (double from_s = 0.50; from_s < 0.95; from_s += 0.02) {
    EXPECT_GT(rms(from_s), rms(from_s + 0.02)) << from_s;
  }
}

}  // namespace
}  // namespace acus::sound
