// Presets of the display, curves of grey, edges along the lines, persistence over time.
#include "acus/imaging/ultrasound/display/display_options.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/imaging/ultrasound/display/edge_enhancement.h"
#include "acus/imaging/ultrasound/display/frame_persistence.h"
#include "acus/imaging/ultrasound/display/grey_curve.h"

namespace acus::ultrasound {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(DisplayOptions, AllPresetsAreRead) {
  int presets = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(ACUS_SOURCE_DIR) / "configs/displays")) {
    const DisplayOptions display = ReadDisplayOptions(entry.path());
    EXPECT_FALSE(display.name.empty()) << entry.path();
    ++presets;
  }
  EXPECT_GE(presets, 5);
}

TEST(DisplayOptions, WithoutAPresetThereIsTheLogarithmAlone) {
  const DisplayOptions none = ReadDisplayOptions({});
  EXPECT_EQ(none.curve, GreyCurve::kLog);
  EXPECT_EQ(none.compound_angles, 1);
  EXPECT_EQ(none.persistence_s, 0.0);
  EXPECT_EQ(none.edge_strength, 0.0);
  EXPECT_FALSE(none.second_harmonic);
}

TEST(DisplayOptions, AnglesAreSymmetricAndTheFirstIsNotSteered) {
  const DisplayOptions five{.name = {}, .compound_angles = 5, .compound_span_rad = 0.4};
  const double expected[] = {0.0, -0.1, 0.1, -0.2, 0.2};
  for (int look = 0; look < 5; ++look) EXPECT_NEAR(SteeringRad(five, look), expected[look], 1e-12);
}

TEST(DisplayOptions, APhasedProbeDoesNotCompound) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kPhased;
  const DisplayOptions three{.name = {}, .compound_angles = 3, .compound_span_rad = 0.2};
  EXPECT_THAT([&] { ProbeOfLook(probe, three, 0); },
              ThrowsMessage<InputError>(HasSubstr("compound_angles 1")));
  EXPECT_THAT([&] { ProbeOfLook(probe, {.name = {}, .compound_angles = 2}, 0); },
              ThrowsMessage<InputError>(HasSubstr("an odd number")));
}

TEST(GreyCurves, AreWhatTheirFormulasSay) {
  EXPECT_DOUBLE_EQ(GreyOfLevel(GreyCurve::kLog, 1.0, 60.0, 0.3), 0.3);
  // 30 dB below white, to the power 0.4: 12 dB below.
  EXPECT_NEAR(GreyOfLevel(GreyCurve::kPower, 0.4, 60.0, 0.5), std::pow(10.0, -12.0 / 20.0), 1e-12);
  EXPECT_NEAR(GreyOfLevel(GreyCurve::kSigmoid, 1.0, 60.0, 0.5), 0.5, 1e-12);
  // Its slope in the middle is 1 / width over what the stretching takes: tanh(1 / width).
  const double slope = (GreyOfLevel(GreyCurve::kSigmoid, 0.7, 60.0, 0.5001) -
                        GreyOfLevel(GreyCurve::kSigmoid, 0.7, 60.0, 0.4999)) /
                       0.0002;
  EXPECT_NEAR(slope, 1.0 / 0.7 / std::tanh(1.0 / 0.7), 1e-3);
  for (const GreyCurve curve : {GreyCurve::kLog, GreyCurve::kPower, GreyCurve::kSigmoid}) {
    const auto table = GreyTable(curve, 0.7, 60.0);
    EXPECT_EQ(table.front(), 0);
    EXPECT_EQ(table.back(), 255);
    for (std::size_t n = 1; n < 256; ++n) EXPECT_GE(table[n], table[n - 1]);
  }
  EXPECT_THROW(GreyTable(GreyCurve::kPower, 0.0, 60.0), InputError);
}

/// One lane of greys through the enhancement.
std::vector<std::uint8_t> Enhanced(const EdgeEnhancement& edges,
                                   const std::vector<std::uint8_t>& in) {
  std::vector<std::uint8_t> out(in.size());
  for (int k = 0; k < static_cast<int>(in.size()); ++k) {
    edges.EnhanceRow(in.data(), 1, static_cast<int>(in.size()), k, 1,
                     out.data() + static_cast<std::ptrdiff_t>(k));
  }
  return out;
}

TEST(EdgeEnhancement, RaisesAPatternByItsFrequencyResponse) {
  constexpr double kStepMm = 0.1;
  constexpr double kSigmaMm = 0.5;
  const EdgeEnhancement edges(0.8, kSigmaMm, kStepMm);
  for (const double period_mm : {1.0, 2.0, 4.0, 20.0}) {
    const double q = 2.0 * std::numbers::pi / period_mm;
    std::vector<std::uint8_t> in;
    for (int k = 0; k < 800; ++k) {
      in.push_back(
          static_cast<std::uint8_t>(std::lround(128.0 + 60.0 * std::sin(q * k * kStepMm))));
    }
    const auto out = Enhanced(edges, in);
    double amplitude = 0.0;
    for (int k = 200; k < 600; ++k) {
      amplitude += out[static_cast<std::size_t>(k)] * std::sin(q * k * kStepMm) / 200.0;
    }
    const double expected =
        60.0 * (1.0 + 0.8 * (1.0 - std::exp(-0.5 * q * q * kSigmaMm * kSigmaMm)));
    EXPECT_NEAR(amplitude, expected, 0.6) << period_mm;
  }
}

TEST(EdgeEnhancement, AStepOvershootsAndEvenAreasStay) {
  const EdgeEnhancement edges(1.0, 0.8, 0.1);
  std::vector<std::uint8_t> in(200, 60);
  std::fill(in.begin() + 100, in.end(), std::uint8_t{140});
  const auto out = Enhanced(edges, in);
  EXPECT_EQ(out[10], 60);
  EXPECT_EQ(out[190], 140);
  // Half of the step, less half of the middle's weight: 0.1 / (0.8 sqrt(2 pi)) / 2.
  EXPECT_NEAR(out[100] - 140, 80.0 * (0.5 - 0.025), 1.5);
  EXPECT_NEAR(60 - out[99], 80.0 * (0.5 - 0.025), 1.5);
  // At the ends of the greys it is cut off.
  std::vector<std::uint8_t> ends(200, 0);
  std::fill(ends.begin() + 100, ends.end(), std::uint8_t{255});
  EXPECT_EQ(Enhanced(edges, ends), ends);
}

TEST(EdgeEnhancement, OffIsOffAndBadSettingsAreRefused) {
  EXPECT_FALSE(EdgeEnhancement(0.0, 0.5, 0.1).on());
  EXPECT_THROW(EdgeEnhancement(-1.0, 0.5, 0.1), InputError);
  EXPECT_THROW(EdgeEnhancement(std::nan(""), 0.5, 0.1), InputError);
  EXPECT_THAT([] { EdgeEnhancement(1.0, 5.0, 0.01); },
              ThrowsMessage<InputError>(HasSubstr("edge_sigma_mm")));
}

image::GrayImage Even(std::uint8_t grey) {
  return {.width = 40, .height = 30, .pixels = std::vector<std::uint8_t>(1200, grey)};
}

constexpr std::int64_t kMs = 1'000'000;

TEST(FramePersistence, AStepIsPassedByTimeNotByFrames) {
  const std::vector<std::vector<int>> frames_ms = {
      {10, 20, 30, 40, 50, 60, 70, 80, 90, 100}, {100}, {3, 55, 56, 99, 100}};
  for (const std::vector<int>& times_ms : frames_ms) {
    FramePersistence persistence(0.1);
    image::GrayImage out;
    persistence.Add(0, Even(0), out);
    for (const int ms : times_ms) persistence.Add(ms * kMs, Even(200), out);
    EXPECT_EQ(out.pixels[77], std::lround(200.0 * (1.0 - std::exp(-1.0))));
  }
}

TEST(FramePersistence, NoiseFallsAsTheClosedFormSays) {
  constexpr double kTauS = 0.12;
  constexpr int kDtMs = 40;
  FramePersistence persistence(kTauS);
  RandomStream random(3, "frames");
  image::GrayImage frame = Even(0);
  image::GrayImage out;
  double before = 0.0;
  double after = 0.0;
  int count = 0;
  for (int n = 0; n < 400; ++n) {
    for (auto& pixel : frame.pixels) {
      pixel = static_cast<std::uint8_t>(std::clamp(128.0 + 20.0 * random.Normal(), 0.0, 255.0));
    }
    persistence.Add(n * kDtMs * kMs, frame, out);
    if (n < 30) continue;
    for (std::size_t p = 0; p < frame.pixels.size(); ++p) {
      before += std::pow(frame.pixels[p] - 127.5, 2);
      after += std::pow(out.pixels[p] - 127.5, 2);
      ++count;
    }
  }
  const double expected = std::sqrt(std::tanh(1e-3 * kDtMs / (2.0 * kTauS)));
  EXPECT_NEAR(std::sqrt(after / before), expected, 0.01);
  EXPECT_GT(count, 0);
}

TEST(FramePersistence, StartsAgainAfterAResetAnotherSizeAndATimeThatRunsBack) {
  FramePersistence persistence(1.0);
  image::GrayImage out;
  persistence.Add(0, Even(0), out);
  persistence.Reset();
  persistence.Add(10 * kMs, Even(90), out);
  EXPECT_EQ(out.pixels[5], 90);
  persistence.Add(5 * kMs, Even(50), out);
  EXPECT_EQ(out.pixels[5], 50);
  image::GrayImage small{.width = 2, .height = 2, .pixels = {1, 2, 3, 4}};
  persistence.Add(20 * kMs, small, out);
  EXPECT_EQ(out.pixels, small.pixels);
  // The same moment again changes nothing.
  const image::GrayImage before = out;
  small.pixels = {200, 200, 200, 200};
  persistence.Add(20 * kMs, small, out);
  EXPECT_EQ(out.pixels, before.pixels);
  EXPECT_THROW(FramePersistence(-0.1), InputError);
  EXPECT_THROW(FramePersistence(std::nan("")), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
