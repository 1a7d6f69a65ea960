#include "acus/imaging/rf/channel_simulator.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/imaging/rf/analytic.h"
#include "rf_scenes.h"

namespace acus::rf {
namespace {

/// When the envelope of a trace is largest, and how large.
std::pair<double, double> PeakOf(const ChannelData& data, int transmit, int element) {
  const Baseband baseband = BasebandOf(data, 5.0, 8, 1);
  const std::complex<float>* trace = baseband.Trace(transmit, element);
  int best = 0;
  for (int k = 0; k < baseband.samples; ++k) {
    if (std::abs(trace[k]) > std::abs(trace[best])) best = k;
  }
  return {baseband.start_us + best / baseband.sampling_mhz, std::abs(trace[best])};
}

TEST(ChannelSimulator, OneElementHearsAPointAfterThePathThereAndBack) {
  const Array one = RowOf(1);
  const Eigen::Vector2d place(3.0, 20.0);
  ChannelOptions options = Lossless(2000);
  options.start_us = 5.0;
  const ChannelData data = Recorded(one, {Transmit{}}, {{place, 2.0}}, options);
  const auto [time_us, peak] = PeakOf(data, 0, 0);
  EXPECT_NEAR(time_us, 2.0 * place.norm() / 1.54, 0.004);
  // Directivity and 1/r, there and back.
  const double once = Directivity(0.25, 5.0, 1.54, place.y() / place.norm()) / place.norm();
  EXPECT_NEAR(peak / (2.0 * once * once), 1.0, 0.01);
}

TEST(ChannelSimulator, ExchangingTransmitterAndReceiverChangesNothing) {
  // With one element on its own at each end: two arrays of one, placed by hand.
  Array pair = RowOf(2, 10.0, 0.25);
  const std::vector<Scatterer> point = {{{1.7, 15.0}, 1.0}};
  // Steered so far that the other element fires after the tail: only one transmits.
  ChannelOptions options = Lossless(2400);
  options.transmit_tail_us = 0.4;
  const Transmit left{1.2, {}};
  const Transmit right{-1.2, {}};
  const ChannelData data = Recorded(pair, {left, right}, point, options);
  const Baseband baseband = BasebandOf(data, 5.0, 1, 1);
  // Up to the nearest sixteenth of a sample at which a pulse begins.
  const double peak = PeakOf(data, 0, 1).second;
  ASSERT_GT(peak, 1e-4);
  for (int k = 0; k < baseband.samples; ++k) {
    ASSERT_LT(std::abs(baseband.Trace(0, 1)[k] - baseband.Trace(1, 0)[k]), 0.01 * peak);
  }
}

// An element's own echo of a point, at any fraction of a sample: a Gaussian times a cosine.
TEST(ChannelSimulator, AnEchoIsTheDelayedPulseBetweenSamplesToo) {
  struct Recording {
    int phases;
    double bandwidth;
    double tolerance;
  };
  // Few phases: linear between them, h^2 / 8 of the carrier. A short pulse: cubic between samples.
  for (const Recording& recording : {Recording{4, 0.5, 0.025}, Recording{64, 0.7, 0.01}}) {
    const Array one = RowOf(1);
    const Pulse pulse{5.0, recording.bandwidth, 0.0};
    ChannelOptions options = Lossless(700);
    options.sampling_mhz = 20.0;
    options.phases = recording.phases;
    for (int n = 0; n < 11; ++n) {
      const double y_mm = 20.0 + 0.0035 * n;  // Over one sample.
      const ChannelData data = Recorded(one, {Transmit{}}, {{{0.0, y_mm}, 1.0}}, options, 1, pulse);
      double largest = 0.0;
      for (int k = 0; k < options.samples; ++k) {
        const double t_us = k / options.sampling_mhz - 2.0 * y_mm / options.sound_speed_mm_per_us;
        const double turns = 2.0 * std::numbers::pi * pulse.SigmaMhz() * t_us;
        const double expected = std::exp(-0.5 * turns * turns) *
                                std::cos(2.0 * std::numbers::pi * pulse.frequency_mhz * t_us);
        const double value = data.values[static_cast<std::size_t>(k)] * y_mm * y_mm;
        largest = std::max(largest, std::abs(value - expected));
      }
      EXPECT_LT(largest, recording.tolerance) << recording.phases << " at " << y_mm;
    }
  }
}

TEST(ChannelSimulator, ALateWaveFadesByARaisedCosine) {
  const Array pair = RowOf(2, 10.0);
  const Eigen::Vector2d place(3.0, 15.0);
  const double near_us = std::hypot(2.0, 15.0) / 1.54;
  const double far_us = std::hypot(8.0, 15.0) / 1.54;
  const auto late_echo = [&](double tail_us) {
    ChannelOptions options = Lossless(1200);
    options.transmit_tail_us = tail_us;
    const ChannelData data = Recorded(pair, {Transmit{}}, {{place, 1.0}}, options);
    const Baseband baseband = BasebandOf(data, 5.0, 8, 1);
    const int near = pair.elements[1].position_mm.x() > 0.0 ? 1 : 0;
    const auto at = std::lround((far_us + near_us) * baseband.sampling_mhz);
    return std::abs(baseband.Trace(0, near)[at]);
  };
  const double whole = late_echo(10.0);
  ASSERT_GT(whole, 1e-5);
  for (const double late : {0.3, 0.55, 0.65, 0.75, 0.85, 1.05}) {
    const double expected = late < 0.5   ? 1.0
                            : late < 1.0 ? 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * late)
                                         : 0.0;
    EXPECT_NEAR(late_echo((far_us - near_us) / late) / whole, expected, 0.02) << late;
  }
}

TEST(ChannelSimulator, EchoesAdd) {
  const Array array = RowOf(8);
  const Scatterer a{{1.0, 12.0}, 1.0};
  const Scatterer b{{-2.0, 12.4}, -3.0};
  const ChannelOptions options = Lossless(1000);
  const auto both = Recorded(array, {Transmit{}}, {a, b}, options);
  const auto only_a = Recorded(array, {Transmit{}}, {a}, options);
  const auto only_b = Recorded(array, {Transmit{}}, {b}, options);
  for (std::size_t i = 0; i < both.values.size(); ++i) {
    ASSERT_NEAR(both.values[i], only_a.values[i] + only_b.values[i], 1e-6);
  }
}

TEST(ChannelSimulator, AttenuationIsThatOfTheGaussiansClosedForm) {
  const Array one = RowOf(1);
  ChannelOptions options = Lossless(2700);
  options.attenuation_db_per_cm_mhz = 0.5;
  const Pulse pulse{5.0, 0.4, 0.0};
  const Scatterer point{{0.0, 45.0}, 1.0};
  const auto lossy = Recorded(one, {Transmit{}}, {point}, options, 1, pulse);
  options.attenuation_db_per_cm_mhz = 0.0;
  const auto lossless = Recorded(one, {Transmit{}}, {point}, options, 1, pulse);
  const auto expected = AttenuateGaussian(5.0, pulse.SigmaMhz(), NeperPerMhz(0.5, 90.0));
  EXPECT_NEAR(PeakOf(lossy, 0, 0).second / PeakOf(lossless, 0, 0).second / expected.gain, 1.0,
              0.02);
}

TEST(ChannelSimulator, AFocusedWaveIsStrongestAtItsFocus) {
  const Array array = RowOf(64);
  const Transmit focused{0.0, Eigen::Vector2d(0.0, 20.0)};
  const ChannelOptions options = Lossless(2000);
  const auto at = [&](double x) {
    return PeakOf(Recorded(array, {focused}, {{{x, 20.0}, 1.0}}, options), 0, 32).second;
  };
  EXPECT_GT(at(0.0), 5.0 * at(2.0));
  const TransmitTiming timing(array, focused, 1.54);
  const auto [time_us, peak] =
      PeakOf(Recorded(array, {focused}, {{{0.0, 20.0}, 1.0}}, options), 0, 32);
  EXPECT_NEAR(time_us, timing.ArrivalUs({0.0, 20.0}) + std::hypot(0.15, 20.0) / 1.54, 0.02);
}

TEST(ChannelSimulator, TheSameBitsWithAnyNumberOfThreads) {
  const auto scatterers = ScatterersIn({{-3.0, 2.0}, {3.0, 12.0}, 5.0}, 7);
  const Array array = RowOf(16);
  ChannelOptions options;
  options.samples = 400;
  const std::vector<Transmit> transmits = {{-0.1, {}}, {0.1, {}}};
  const auto one = Recorded(array, transmits, scatterers, options, 1);
  const auto three = Recorded(array, transmits, scatterers, options, 3);
  EXPECT_TRUE(one.values == three.values);
}

TEST(ChannelSimulatorHardCases, GiveFiniteNumbers) {
  const Array array = RowOf(4);
  ChannelOptions options;
  options.samples = 200;
  const Eigen::Vector2d element = array.elements[1].position_mm;
  const auto silent = Recorded(array, {Transmit{}}, {}, options);
  EXPECT_TRUE(std::ranges::all_of(silent.values, [](float v) { return v == 0.0F; }));
  // On an element, behind the face, beside it, far beyond the recording.
  for (const Eigen::Vector2d& place :
       {element, Eigen::Vector2d(0.0, -5.0), Eigen::Vector2d(50.0, 0.0),
        Eigen::Vector2d(0.0, 900.0), Eigen::Vector2d(0.0, 1e-9)}) {
    const auto data = Recorded(array, {Transmit{}}, {{place, 1.0}}, options);
    EXPECT_TRUE(std::ranges::all_of(data.values, [](float v) { return std::isfinite(v); }))
        << place;
  }
  const auto behind = Recorded(array, {Transmit{}}, {{{0.0, -5.0}, 1.0}}, options);
  EXPECT_TRUE(std::ranges::all_of(behind.values, [](float v) { return v == 0.0F; }));
}

TEST(ChannelSimulatorHardCases, RefusesWhatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Array array = RowOf(4);
  EXPECT_THROW(Recorded(array, {Transmit{}}, {{{nan, 5.0}, 1.0}}, {}), InputError);
  EXPECT_THROW(Recorded(array, {Transmit{}}, {{{0.0, 5.0}, nan}}, {}), InputError);
  EXPECT_THROW(Recorded(array, {Transmit{nan, {}}}, {{{0.0, 5.0}, 1.0}}, {}), InputError);
  EXPECT_THROW(Recorded(array, {}, {}, {}), InputError);
  ChannelOptions options;
  options.sampling_mhz = 8.0;  // Below twice 5 MHz.
  EXPECT_THROW(Recorded(array, {Transmit{}}, {}, options), InputError);
  EXPECT_THROW(ScatterersIn({{0, 0}, {1000, 1000}, 100.0}, 1), InputError);
  EXPECT_THROW(ScatterersIn({{0, 0}, {-1, 1}, 1.0}, 1), InputError);
}

}  // namespace
}  // namespace acus::rf
