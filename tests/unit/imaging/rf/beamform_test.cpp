#include "acus/imaging/rf/beamform.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/imaging/rf/compression.h"
#include "rf_scenes.h"
#include "support/envelope_measures.h"

namespace acus::rf {
namespace {

IqImage ImageOf(const ChannelData& data, const Array& array, const std::vector<Transmit>& transmits,
                const PixelGrid& grid, double f_number, int threads = 2) {
  BeamformOptions options;
  options.f_number = f_number;
  return DelayAndSum(BasebandOf(data, 5.0, 4, threads), array, transmits, grid, options, threads);
}

/// Narrow band, small elements: the width of sinc^1 across, 1.207 wavelengths times the F-number.
TEST(DelayAndSum, APointIsAsWideAsASincOfTheFNumber) {
  const Array array = RowOf(128, 0.15, 0.01);
  const Pulse narrow{5.0, 0.15, 0.0};
  ChannelOptions options = Lossless(2000);
  options.pulse_half_us = 2.4;
  const std::vector<Transmit> plane = {Transmit{}};
  for (const double f_number : {2.0, 3.0, 4.0}) {
    const auto data = Recorded(array, plane, {{{0.0, 30.0}, 1.0}}, options, 2, narrow);
    const IqImage image =
        ImageOf(data, array, plane, {{-3.0, 28.0}, {0.02, 0.02}, 301, 201}, f_number);
    const PointWidths widths = WidthsOfBrightest(image);
    const double aperture_mm = std::floor(30.0 / f_number / 0.15) * 0.15;
    EXPECT_NEAR(widths.lateral_mm / (1.207 * 0.308 * 30.0 / aperture_mm), 1.0, 0.04) << f_number;
    EXPECT_NEAR(widths.peak_mm.x(), 0.0, 0.021);
    EXPECT_NEAR(widths.peak_mm.y(), 30.0, 0.04);
  }
}

/// The envelope of the pulse, at half the speed of sound.
TEST(DelayAndSum, APointIsAsLongAsThePulse) {
  const Array array = RowOf(64);
  const std::vector<Transmit> plane = {Transmit{}};
  const auto data = Recorded(array, plane, {{{0.0, 25.0}, 1.0}}, Lossless(2000));
  const IqImage image = ImageOf(data, array, plane, {{-2.0, 23.0}, {0.05, 0.01}, 81, 401}, 4.0);
  const double sigma_us = 1.0 / (2.0 * 3.14159265 * Pulse{}.SigmaMhz());
  const double expected_mm = 0.5 * 1.54 * 2.3548 * sigma_us;
  EXPECT_NEAR(WidthsOfBrightest(image).axial_mm / expected_mm, 1.0, 0.04);
}

/// Waves at all angles agree where the point is: steering loses nothing.
TEST(DelayAndSum, PlaneWavesAddUpInPhase) {
  const Array array = RowOf(64);
  const std::vector<Transmit> one = {Transmit{}};
  const std::vector<Transmit> five = {{-0.1, {}}, {-0.05, {}}, {0.0, {}}, {0.05, {}}, {0.1, {}}};
  const std::vector<Scatterer> point = {{{1.0, 20.0}, 1.0}};
  const PixelGrid grid{{-1.0, 19.0}, {0.05, 0.02}, 81, 101};
  const auto peak = [&](const std::vector<Transmit>& transmits) {
    const auto data = Recorded(array, transmits, point, Lossless(1600));
    const auto image = ImageOf(data, array, transmits, grid, 1.5);
    const PointWidths widths = WidthsOfBrightest(image);
    EXPECT_NEAR(widths.peak_mm.x(), 1.0, 0.06);
    EXPECT_NEAR(widths.peak_mm.y(), 20.0, 0.04);
    return std::abs(image.At(40, 50));
  };
  EXPECT_NEAR(peak(five) / peak(one), 1.0, 0.03);
}

TEST(DelayAndSum, ACurvedArrayFindsThePointToo) {
  acoustics::Probe probe;
  probe.kind = acoustics::ProbeKind::kCurvilinear;
  probe.elements = 64;
  probe.pitch_mm = 0.4;
  probe.radius_mm = 40.0;
  const Array array = ArrayOf(probe, 0.3);
  const std::vector<Transmit> waves = {Transmit{0.0, Eigen::Vector2d(3.0, 60.0)}};
  const auto data = Recorded(array, waves, {{{2.0, 30.0}, 1.0}}, Lossless(2400));
  const auto image = ImageOf(data, array, waves, {{-1.0, 28.0}, {0.05, 0.05}, 121, 81}, 1.5);
  const PointWidths widths = WidthsOfBrightest(image);
  EXPECT_NEAR(widths.peak_mm.x(), 2.0, 0.11);
  EXPECT_NEAR(widths.peak_mm.y(), 30.0, 0.11);
}

/// Rayleigh: mean over standard deviation is 1.913.
TEST(DelayAndSum, SpeckleIsRayleigh) {
  const Array array = RowOf(48);
  const std::vector<Transmit> plane = {Transmit{}};
  ChannelOptions options;
  options.attenuation_db_per_cm_mhz = 0.0;
  options.samples = 900;
  std::vector<float> values;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto scatterers = ScatterersIn({{-7.0, 14.0}, {7.0, 28.0}, 80.0}, seed);
    const auto data = Recorded(array, plane, scatterers, options, 2, {5.0, 0.3, 0.0});
    const auto image = ImageOf(data, array, plane, {{-4.0, 18.0}, {0.2, 0.1}, 41, 81}, 2.0);
    const auto envelope = Envelope(image);
    values.insert(values.end(), envelope.begin(), envelope.end());
  }
  EXPECT_NEAR(SpeckleSnr(values), 1.913, 0.08);
}

TEST(DelayAndSum, TheSameBitsWithAnyNumberOfThreads) {
  const Array array = RowOf(16);
  const std::vector<Transmit> plane = {Transmit{}};
  const auto data = Recorded(array, plane, {{{0.0, 8.0}, 1.0}}, Lossless(800));
  const PixelGrid grid{{-2.0, 6.0}, {0.1, 0.1}, 41, 41};
  EXPECT_TRUE(ImageOf(data, array, plane, grid, 1.5, 1).values ==
              ImageOf(data, array, plane, grid, 1.5, 3).values);
}

TEST(DelayAndSumHardCases, RefusesWhatDoesNotFit) {
  const Array array = RowOf(4);
  const std::vector<Transmit> plane = {Transmit{}};
  ChannelData data = Recorded(array, plane, {}, Lossless(100));
  const PixelGrid grid{{0.0, 1.0}, {0.1, 0.1}, 4, 4};
  EXPECT_THROW(ImageOf(data, RowOf(5), plane, grid, 1.5), InputError);
  EXPECT_THROW(ImageOf(data, array, {{}, {}}, grid, 1.5), InputError);
  EXPECT_THROW(ImageOf(data, array, plane, {{0, 0}, {1, 1}, 0, 4}, 1.5), InputError);
  const IqImage empty = ImageOf(data, array, plane, grid, 1.5);
  EXPECT_EQ(Compressed(empty, 60.0).pixels, std::vector<std::uint8_t>(16, 0));
  EXPECT_THROW(WidthsOfBrightest(empty), NoAnswerError);
  data.values[17] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(ImageOf(data, array, plane, grid, 1.5), InputError);
}

}  // namespace
}  // namespace acus::rf
