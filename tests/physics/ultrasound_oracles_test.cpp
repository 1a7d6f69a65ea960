// The aperture model beside tables of independent simulators:
// testdata/ultrasound_oracles/README.md.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/aperture/aperture_field.h"
#include "acus/imaging/ultrasound/beams/refraction.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"
#include "acus/imaging/ultrasound/columns/echo_list.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Clear;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::TableOf;
using testing_support::TargetProbe;

/// Rows after the header, as text.
std::vector<std::vector<std::string>> OracleTable(const std::string& name) {
  std::ifstream in(std::string(ACUS_SOURCE_DIR) + "/testdata/ultrasound_oracles/" + name);
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::stringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    rows.push_back(cells);
  }
  return rows;
}

/// -6 dB width of a profile of amplitudes, in samples.
double OracleHalfWidth(const std::vector<double>& profile) {
  const auto peak = std::max_element(profile.begin(), profile.end()) - profile.begin();
  const double half = 0.5 * profile[static_cast<std::size_t>(peak)];
  const auto cross = [&](std::ptrdiff_t step) {
    auto n = peak;
    while (profile[static_cast<std::size_t>(n + step)] > half) n += step;
    const double a = profile[static_cast<std::size_t>(n)];
    const double b = profile[static_cast<std::size_t>(n + step)];
    return static_cast<double>(n - peak) + static_cast<double>(step) * (a - half) / (a - b);
  };
  return cross(1) - cross(-1);
}

struct PointSpread {
  double across_mm = 0.0;
  double along_mm = 0.0;
};

/// Of the renderer's filter for one echo in the middle line.
PointSpread SpreadAt(const acoustics::Probe& probe, double depth_mm) {
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const BeamFilter filter(probe, BeamOptions(), grid);
  ComplexBeams beams;
  slicing::BeamImage intensity;
  for (slicing::BeamImage* image : {&beams.re, &beams.im, &intensity}) {
    image->Resize(grid.lines(), grid.samples);
    for (int k = 0; k < grid.samples; ++k) {
      std::fill_n(image->padded_row(k), image->stride(), 0.0F);
    }
  }
  const int line = grid.lines() / 2;
  const int sample = static_cast<int>(std::lround(depth_mm / grid.step_mm));
  EchoList echo;
  echo.Reserve(4);
  echo.Add(filter, sample, line, 1.0F);
  echo.PutInto(filter, beams);
  image::AlignedFloats scratch;
  scratch.Reserve(static_cast<std::size_t>(2 * beams.re.stride()));
  filter.Apply(beams, std::max(0, sample - 256), std::min(grid.samples, sample + 256),
               scratch.data(), intensity);
  std::vector<double> across;
  std::vector<double> along;
  for (int l = 0; l < grid.lines(); ++l) {
    across.push_back(std::sqrt(double{intensity.row(sample)[l]}));
  }
  for (int k = 0; k < grid.samples; ++k) along.push_back(std::sqrt(double{intensity.row(k)[line]}));
  return {OracleHalfWidth(across) * grid.LateralSpacingMm(sample),
          OracleHalfWidth(along) * grid.step_mm};
}

/// How much the directivity of elements widens the focus of an aperture: from a rectangular one
/// (FWHM 1.207 lambda F) towards a cosine one (1.64), by what the outermost element lacks.
double WidenedBy(const acoustics::Probe& probe, double depth_mm) {
  const double half_mm = 0.5 * acoustics::ReceiveApertureMm(probe, depth_mm);
  double sine = half_mm / std::hypot(half_mm, depth_mm);
  if (probe.radius_mm > 0.0) {
    // Outer elements of a curved face look away from the line.
    const double turn = half_mm / probe.radius_mm;
    const double beside = probe.radius_mm * std::sin(turn);
    const double above = probe.radius_mm * (1.0 - std::cos(turn));
    sine = std::sin(turn + std::atan2(beside, depth_mm + above));
  }
  const double width = SideLobes::kElementShare * probe.pitch_mm / acoustics::WavelengthMm(probe);
  return 0.36 * (1.0 - ElementDirectivity(width, sine));
}

// Widths across: in the focus the product of two Gaussians for a rectangular aperture is 4 %
// narrower than sinc^2, and the directivity, which takes the upper end of the band, adds 3 %; out
// of the focus a Gaussian beam stands for Fresnel's pattern of a rectangular aperture, 10 %. The
// filter leaves points narrower than speckle by half of its grain, 3 %. Along: a Gaussian spectrum
// gives the shortest pulse of its -6 dB bandwidth, 0.441 c / B; a rectangular one the longest,
// 0.603 c / B; 3 % for the band as above.
TEST(UltrasoundOracles, PointSpreadsAreThoseOfSimus) {
  int count = 0;
  for (const auto& row : OracleTable("point_spread_simus.csv")) {
    if (row[1] != "0") continue;
    acoustics::Probe probe =
        acoustics::ReadProbe(std::string(ACUS_SOURCE_DIR) + "/configs/probes/" + row[0] + ".json");
    const double hertz = probe.frequency_mhz;
    probe.frequency_mhz = std::stod(row[6]);
    probe.fractional_bandwidth = std::stod(row[5]) * hertz / probe.frequency_mhz;
    probe.scan_lines = 1024;
    probe.samples_per_line = 4096;
    const double depth_mm = std::stod(row[2]);
    const PointSpread ours = SpreadAt(probe, depth_mm);
    const double across = std::stod(row[3]) / ours.across_mm - 1.0;
    const bool in_focus = depth_mm == probe.focus_mm;
    const double most = (in_focus ? 0.07 : 0.10) + 0.03 + WidenedBy(probe, depth_mm);
    EXPECT_GT(across, in_focus ? -0.04 : -0.10) << row[0] << " " << depth_mm;
    EXPECT_LT(across, most) << row[0] << " " << depth_mm;
    const double along = std::stod(row[4]) / ours.along_mm;
    EXPECT_GT(along, 0.97) << row[0] << " " << depth_mm;
    EXPECT_LT(along, 1.03 * 0.603 / 0.441) << row[0] << " " << depth_mm;
    ++count;
  }
  EXPECT_EQ(count, 13);
}

/// The beam of the wave solver's tables.
acoustics::Probe WaveProbe() {
  acoustics::Probe probe = TargetProbe();
  probe.frequency_mhz = 2.5;
  probe.width_mm = 51.2;
  probe.scan_lines = 257;
  probe.pitch_mm = 0.4;
  probe.focus_mm = 36.0;
  return probe;
}

// Rays know no diffraction: the zone that a wave of lambda = 0.62 mm blurs behind an edge is
// sqrt(lambda z1 z2 / z) = 2.3 mm (first Fresnel zone, z1 = 16, z2 = 20, z = 36 mm), a sixth of
// the aperture's width there, 8 mm: 0.15 of the amplitude, and a third of that zone of place.
TEST(UltrasoundOracles, EdgeShadowsOfCylindersAreThoseOfAWaveSolver) {
  std::vector<double> gain(257);
  for (const double speed : {1500.0, 1580.0, 1450.0}) {
    const volume::LabelMap labels = LabelledBlock(
        {160, 140, 10}, 0.4, {{1, "near"}, {2, "far"}}, [](double x, double y, double) {
          return static_cast<volume::Label>(std::hypot(x - 32.0, y - 20.0) < 6.0 ? 2 : 1);
        });
    const auto table = TableOf({{"near", Clear(1540.0)}, {"far", Clear(speed)}});
    const BeamTissue tissue{.labels = &labels, .acoustics = &table};
    const acoustics::Probe probe = WaveProbe();
    const acoustics::ScanGrid rows = acoustics::BeamGridOf(probe);
    const ApertureRays rays(probe, rows, 31);
    Refraction refraction(SpeedVolume(tissue, BeamMaterials(tissue, BeamOptions(), probe, 1.0)),
                          labels.geometry, probe, rows, rays);
    refraction.Trace(FaceAt(32.0, 4.0, 2.0), nullptr, 1);
    std::vector<float> at_36(257);
    refraction.GainRow(360, at_36.data());
    double darkest_wave = 1.0;
    double darkest_ours = 1.0;
    double wave_at = 0.0;
    double ours_at = 0.0;
    double squares = 0.0;
    int count = 0;
    for (const auto& row : OracleTable("cylinder_wave.csv")) {
      if (std::stod(row[0]) != speed) continue;
      const double line_mm = std::stod(row[1]);
      const double wave = std::stod(row[2]);
      const int line = 128 + static_cast<int>(std::lround(line_mm / 0.2));
      const double ours = at_36[static_cast<std::size_t>(line)];
      // Half of the beam's width at half maximum.
      EXPECT_NEAR(refraction.ShiftMm(line, 360).x(), std::stod(row[3]), 0.74)
          << speed << " " << line_mm;
      if (wave < darkest_wave) {
        darkest_wave = wave;
        wave_at = line_mm;
      }
      if (ours < darkest_ours) {
        darkest_ours = ours;
        ours_at = line_mm;
      }
      squares += (ours - wave) * (ours - wave);
      ++count;
    }
    ASSERT_EQ(count, 13) << speed;
    EXPECT_LT(std::sqrt(squares / count), 0.15) << speed;
    EXPECT_NEAR(ours_at, wave_at, 2.3) << speed;
  }
}

TEST(UltrasoundOracles, TheShadowsEdgeIsThatOfAWaveSolver) {
  const acoustics::Probe probe = WaveProbe();
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, 31);
  ApertureField field(rays, grid.lines(), grid.samples);
  for (int k = 0; k < grid.samples; ++k) {
    for (int l = 0; l < grid.lines(); ++l) field.left(k)[l] = k == 160 && l > 128 ? 0.0F : 1.0F;
  }
  field.March(std::vector<float>(static_cast<std::size_t>(grid.lines()) + 16, 1.0F), 1);
  double squares = 0.0;
  int count = 0;
  for (const auto& row : OracleTable("screen_wave.csv")) {
    const double line_mm = std::stod(row[0]);
    const int line = 128 + static_cast<int>(std::lround(line_mm / 0.2));
    const double ours = field.arriving(360)[line];
    squares += std::pow(ours - std::stod(row[1]), 2.0);
    ++count;
  }
  ASSERT_EQ(count, 9);
  EXPECT_LT(std::sqrt(squares / count), 0.15);
}

}  // namespace
}  // namespace acus::ultrasound
