// Side lobes and grating lobes of an array against closed forms.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Db;
using testing_support::TargetProbe;

constexpr double kNarrow = 1e-4;  ///< Of a continuous wave.

double LobeDb(double energy) {
  return 10.0 * std::log10(energy);
}

// Continuous waves: |sin(N x) / (N sin x)|^2, x = pi pitch sine / lambda.
TEST(UltrasoundSideLobes, ALongPulseHasTheArrayFactor) {
  constexpr int kElements = 32;
  for (double sine = 0.01; sine < 0.9; sine += 0.037) {
    const double x = std::numbers::pi * 0.5 * sine;
    const double factor = std::sin(kElements * x) / (kElements * std::sin(x));
    EXPECT_NEAR(ArrayEnergy(0.5, kElements, sine, kNarrow, Apodisation::kRectangular),
                factor * factor, 1e-6);
  }
}

/// Highest energy beyond the first minimum.
double FirstSideLobe(Apodisation apodisation) {
  double before = 2.0;
  bool beyond = false;
  double highest = 0.0;
  for (double sine = 0.0; sine < 0.3; sine += 5e-4) {
    const double energy = ArrayEnergy(0.5, 64, sine, kNarrow, apodisation);
    beyond = beyond || energy > before;
    if (beyond) highest = std::max(highest, energy);
    before = energy;
  }
  return LobeDb(highest);
}

// Harris, On the use of windows for harmonic analysis, Proc. IEEE 66:51 (1978), table 1: -13, -23
// and -32 dB (to the nearest dB, and half a dB for an array of 64).
TEST(UltrasoundSideLobes, ApodisationLowersThem) {
  EXPECT_NEAR(FirstSideLobe(Apodisation::kRectangular), -13.3, 0.5);
  EXPECT_NEAR(FirstSideLobe(Apodisation::kCosine), -23.0, 0.5);
  EXPECT_NEAR(FirstSideLobe(Apodisation::kHann), -32.0, 1.0);
}

TEST(UltrasoundSideLobes, GratingLobesLieWhereThePitchSays) {
  for (const double pitch : {1.2, 1.6, 2.5}) {
    double best = 0.3;
    for (double sine = 0.3; sine < 0.95; sine += 1e-3) {
      const auto at = [&](double s) {
        return ArrayEnergy(pitch, 48, s, kNarrow, Apodisation::kRectangular);
      };
      if (at(sine) > at(best)) best = sine;
    }
    EXPECT_NEAR(best, 1.0 / pitch, 2e-3);
    EXPECT_NEAR(ArrayEnergy(pitch, 48, 1.0 / pitch, kNarrow, Apodisation::kRectangular), 1.0, 1e-3);
  }
}

// At the grating lobe the elements are one period apart: a pulse whose energy autocorrelation is
// exp(-(2 pi b n)^2) after n periods leaves 1/N sum_n (1 - |n| / N) of it.
TEST(UltrasoundSideLobes, ShortPulsesSmearGratingLobes) {
  constexpr int kElements = 64;
  for (const double bandwidth : {0.3, 0.6, 0.9}) {
    const double b = bandwidth / (2.0 * std::sqrt(2.0 * std::numbers::ln2)) / std::numbers::sqrt2;
    double expected = 0.0;
    for (int n = -kElements + 1; n < kElements; ++n) {
      const double spread = 2.0 * std::numbers::pi * b * n;
      expected += (1.0 - std::abs(n) / double{kElements}) * std::exp(-spread * spread) / kElements;
    }
    EXPECT_NEAR(
        LobeDb(ArrayEnergy(1.5, kElements, 1.0 / 1.5, bandwidth, Apodisation::kRectangular)),
        LobeDb(expected), 0.01);
  }
}

TEST(UltrasoundSideLobes, ElementsHaveTheirDirectivity) {
  EXPECT_NEAR(ElementDirectivity(0.5, 0.0), 1.0, 1e-12);
  EXPECT_NEAR(ElementDirectivity(1.0, 0.5), 2.0 / std::numbers::pi * std::sqrt(0.75), 1e-12);
  EXPECT_NEAR(ElementDirectivity(2.0, 0.5), 0.0, 1e-12);
}

/// Row of the brightest ghost in a line of one reflector, and its intensity.
std::pair<int, double> GhostIn(const acoustics::Probe& probe, int reflector_line, int row,
                               int line) {
  const acoustics::ScanGrid rows = acoustics::BeamGridOf(probe);
  SideLobes lobes(probe, rows, Apodisation::kRectangular, 80.0, 1.0);
  slicing::BeamImage echoes;
  echoes.Resize(rows.lines(), rows.samples);
  for (int k = 0; k < rows.samples; ++k) std::fill_n(echoes.row(k), rows.lines(), 0.0F);
  for (int l = reflector_line - 1; l < reflector_line + 3; ++l) echoes.row(row)[l] = 1.0F;
  lobes.Spread(echoes);
  double sum = 0.0;
  double moment = 0.0;
  double peak = 0.0;
  for (int k = 0; k < rows.samples; ++k) {
    const auto value = double{lobes.added(k)[line]};
    sum += value;
    moment += k * value;
    peak = std::max(peak, value);
  }
  return {static_cast<int>(std::lround(moment / std::max(sum, 1e-30))), peak};
}

// A ghost of a grating lobe: as far from the aperture's middle as the reflector, and strongest
// where the sine of the angle is lambda / pitch; nothing there with a fine pitch.
TEST(UltrasoundSideLobes, GhostsLieOnArcsOfEqualRange) {
  acoustics::Probe coarse = TargetProbe();
  coarse.elements = 32;
  coarse.pitch_mm = 0.8;  // lambda is 0.308 mm: the lobe is at asin(0.385), 22.6 degrees.
  coarse.fractional_bandwidth = 0.05;
  acoustics::Probe fine = coarse;
  fine.elements = 166;
  fine.pitch_mm = 0.154;
  constexpr int kRow = 200;  // 20 mm.
  constexpr int kFrom = 25;
  double strongest = 0.0;
  double at_mm = 0.0;
  for (int line = kFrom + 20; line < 120; line += 4) {
    const double beside_mm = (line - kFrom) * 0.2;
    const auto [row, level] = GhostIn(coarse, kFrom, kRow, line);
    if (level > strongest) {
      strongest = level;
      at_mm = beside_mm;
    }
    if (level > 0.0) {
      EXPECT_NEAR(row * 0.1, std::hypot(20.0, beside_mm), 0.5) << line;
    }
  }
  const double expected_mm = 20.0 * 0.385 / std::sqrt(1.0 - 0.385 * 0.385);
  // Bins of four lines, and half a lobe of 12 elements, which elements pull to the middle.
  EXPECT_NEAR(at_mm, expected_mm, 0.8 + 0.5 * 20.0 * 0.308 / (12 * 0.8));
  const int there = kFrom + static_cast<int>(std::lround(expected_mm / 0.2));
  EXPECT_LT(GhostIn(fine, kFrom, kRow, there).second, 0.02 * strongest);
}

}  // namespace
}  // namespace acus::ultrasound
