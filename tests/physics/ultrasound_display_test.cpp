// What displays add, against theory: compounding of independent looks, the second harmonic; and
// that it is the same with any number of threads.
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/beams/side_lobes.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Bare;
using testing_support::Clear;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::Scattering;
using testing_support::StraightLine;
using testing_support::TableOf;
using testing_support::TargetProbe;

constexpr double kDisplayDegree = std::numbers::pi / 180.0;

struct DisplayBlock {
  volume::LabelMap labels = LabelledBlock({60, 90, 200}, 0.5, {{1, "liver"}},
                                          [](double, double, double) { return volume::Label{1}; });
  acoustics::TissueAcousticsTable table;

  explicit DisplayBlock(const acoustics::TissueAcoustics& tissue)
      : table(TableOf({{"liver", tissue}})) {}
  BeamTissue tissue() const { return {.labels = &labels, .acoustics = &table}; }
};

/// Fine enough that scan conversion leaves speckle alone; its mean lies in the middle of the greys.
acoustics::Probe CompoundProbe() {
  acoustics::Probe probe = TargetProbe();
  probe.width_mm = 20.0;
  probe.scan_lines = 257;
  probe.samples_per_line = 1601;
  probe.image_width_px = 512;
  probe.image_height_px = 800;
  probe.dynamic_range_db = 100.0;
  probe.gain_db = -15.0;
  return probe;
}

ApertureOptions ApertureSpeckle() {
  ApertureOptions options;
  options.texture = options.clutter = options.noise = options.ring_down = false;
  options.elevation_planes = 1;
  return options;
}

/// Standard deviation of the greys within 1.5 mm of the focus, dB.
template <typename Renderer>
double SpreadDb(Renderer& renderer, const acoustics::Probe& probe) {
  const image::ImageGeometry geometry = renderer.image();
  const auto row_of = [&](double depth_mm) {
    return static_cast<int>((depth_mm - geometry.depth_of_top_row_mm) / geometry.axial_mm_per_px);
  };
  const int half = static_cast<int>(4.0 / geometry.lateral_mm_per_px);
  double sum = 0.0;
  double square = 0.0;
  double count = 0.0;
  image::GrayImage image;
  for (double z_mm = 2.0; z_mm < 98.0; z_mm += 3.0) {
    renderer.Render(FaceAt(15.0, 0.5, z_mm), std::nullopt, image, 2);
    for (int r = row_of(18.5); r < row_of(21.5); ++r) {
      for (int c = geometry.width_px / 2 - half; c < geometry.width_px / 2 + half; ++c) {
        const double grey = image.At(c, r);
        EXPECT_LT(grey, 255.0);
        sum += grey;
        square += grey * grey;
        count += 1.0;
      }
    }
  }
  const double mean = sum / count;
  EXPECT_GT(mean, 60.0);
  EXPECT_LT(mean, 200.0);
  return std::sqrt(square / count - mean * mean) * probe.dynamic_range_db / 255.0;
}

/// Correlation of the logarithms of two exponential intensities whose fields are correlated by the
/// root of `intensity`: the dilogarithm over pi^2 / 6.
double LogCorrelation(double intensity) {
  double sum = 0.0;
  for (int n = 1; n < 400; ++n) sum += std::pow(intensity, n) / (n * n);
  return sum / (std::numbers::pi * std::numbers::pi / 6.0);
}

/// Of two images whose lines cross under an angle, Gaussian point spread of width sigma.
double LookCorrelation(const acoustics::Probe& probe, double angle_rad) {
  const double k = 2.0 * std::numbers::pi / acoustics::WavelengthMm(probe);
  const double sigma_mm = acoustics::SigmaOfFwhm(acoustics::LateralFwhmMm(probe, 20.0));
  const double turn = k * std::sin(angle_rad) * sigma_mm;
  return LogCorrelation(std::exp(-2.0 * turn * turn));
}

template <typename Renderer, typename Options>
void ExpectContrastOfLooks(const Options& given, double tolerance) {
  const DisplayBlock block(Scattering());
  const acoustics::Probe probe = CompoundProbe();
  Renderer single(block.tissue(), probe, given);
  const double one_db = SpreadDb(single, probe);
  // 10 / ln(10) times the standard deviation of the logarithm of an exponential variable.
  EXPECT_NEAR(one_db, 10.0 / std::numbers::ln10 * std::numbers::pi / std::sqrt(6.0), 0.3);
  for (const double half_deg : {3.0, 5.0, 8.0, 16.0}) {
    Options options = given;
    options.display.compound_angles = 3;
    options.display.compound_span_rad = 2.0 * half_deg * kDisplayDegree;
    Renderer renderer(block.tissue(), probe, options);
    const double near = LookCorrelation(probe, half_deg * kDisplayDegree);
    const double far = LookCorrelation(probe, 2.0 * half_deg * kDisplayDegree);
    const double expected_db = one_db * std::sqrt((3.0 + 2.0 * (2.0 * near + far)) / 9.0);
    const double spread_db = SpreadDb(renderer, probe);
    EXPECT_NEAR(spread_db, expected_db, tolerance * expected_db) << half_deg << " degrees";
  }
}

TEST(UltrasoundCompound, ContrastFallsAsTheCorrelationOfTheLooksSaysInBeams) {
  BeamOptions options = Bare();
  options.speckle = options.point_spread = true;
  ExpectContrastOfLooks<BeamRenderer>(options, 0.06);
}

TEST(UltrasoundCompound, ContrastFallsAsTheCorrelationOfTheLooksSaysThroughTheAperture) {
  ExpectContrastOfLooks<ApertureRenderer>(ApertureSpeckle(), 0.06);
}

// 15 degrees apart: the intensities of neighbours are correlated by 0.05.
TEST(UltrasoundCompound, FiveIndependentLooksLeaveOneOverRootFive) {
  const DisplayBlock block(Scattering());
  acoustics::Probe probe = CompoundProbe();
  // All angles see the middle.
  probe.width_mm = 40.0;
  probe.scan_lines = 513;
  probe.image_width_px = 1024;
  BeamOptions options = Bare();
  options.speckle = options.point_spread = true;
  BeamRenderer single(block.tissue(), probe, options);
  options.display.compound_angles = 5;
  options.display.compound_span_rad = 60.0 * kDisplayDegree;
  BeamRenderer five(block.tissue(), probe, options);
  EXPECT_NEAR(SpreadDb(five, probe) / SpreadDb(single, probe), 1.0 / std::sqrt(5.0), 0.04);
}

TEST(UltrasoundCompound, PlacesAreWhereTheLeaningLinesSayThatTheyAre) {
  for (const auto kind : {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    acoustics::Probe probe = TargetProbe();
    probe.kind = kind;
    if (kind == acoustics::ProbeKind::kCurvilinear) {
      probe.radius_mm = 50.0;
      probe.field_of_view_rad = 1.0;
    }
    for (const double steer_deg : {-20.0, -3.0, 0.0, 12.0}) {
      probe.steer_rad = steer_deg * kDisplayDegree;
      const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
      for (const int line : {0, 40, 128}) {
        for (const int sample : {0, 17, 400}) {
          const auto l = static_cast<std::size_t>(line);
          const acoustics::BeamPlace place = acoustics::PlaceInBeams(
              probe, grid, grid.start_mm[l] + sample * grid.step_mm * grid.direction[l]);
          EXPECT_NEAR(place.line, line, 1e-6);
          EXPECT_NEAR(place.sample, sample, 1e-6);
        }
      }
    }
  }
}

/// A wire across the plane at the focus: its image under one look and under all.
TEST(UltrasoundCompound, AllAnglesSeeAWireAtItsPlace) {
  const DisplayBlock block(Clear());
  acoustics::Probe probe = TargetProbe();
  probe.gain_db = 20.0;
  image::NeedleInImage wire;
  wire.tip_in_ct_mm = {17.0, 20.5, 40.0};
  wire.axis_in_ct = -Eigen::Vector3d::UnitZ();
  wire.length_mm = 60.0;
  wire.radius_mm = 0.02;
  for (const int angles : {1, 3, 5}) {
    BeamOptions options = Bare();
    options.point_spread = true;
    options.display.compound_angles = angles;
    options.display.compound_span_rad = 24.0 * kDisplayDegree;
    BeamRenderer renderer(block.tissue(), probe, options);
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 60.0), wire, image, 1);
    double sum = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (int r = 0; r < image.height; ++r) {
      for (int c = 0; c < image.width; ++c) {
        if (image.At(c, r) < 128) continue;
        sum += image.At(c, r);
        mean += image.At(c, r) * Eigen::Vector2d(c, r);
      }
    }
    ASSERT_GT(sum, 0.0) << angles;
    mean /= sum;
    const image::ImageGeometry geometry = renderer.image();
    EXPECT_NEAR((mean.x() - 0.5 * (image.width - 1)) * geometry.lateral_mm_per_px, 2.0, 0.12);
    EXPECT_NEAR(mean.y() * geometry.axial_mm_per_px, 20.0, 0.12);
  }
}

TEST(UltrasoundHarmonic, BeamsAreNarrowerByRootThreeWhereBothAperturesAreFocused) {
  acoustics::Probe probe = TargetProbe();
  const double fundamental_mm = acoustics::LateralFwhmMm(probe, probe.focus_mm);
  const double thickness_mm = acoustics::ElevationFwhmMm(probe, probe.focus_mm);
  const double pulse_mm = acoustics::AxialFwhmMm(probe);
  probe.second_harmonic = true;
  // 1 / w^2 = 1 / (sent / sqrt 2)^2 + 1 / (received / 2)^2 against 1 / sent^2 + 1 / received^2.
  EXPECT_NEAR(acoustics::LateralFwhmMm(probe, probe.focus_mm) / fundamental_mm,
              1.0 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(acoustics::ElevationFwhmMm(probe, probe.focus_mm) / thickness_mm,
              1.0 / std::sqrt(3.0), 1e-9);
  EXPECT_EQ(acoustics::AxialFwhmMm(probe), pulse_mm);
}

TEST(UltrasoundHarmonic, EchoesAreLostAsSoundOfTwiceTheFrequency) {
  acoustics::TissueAcoustics tissue = Scattering(-20.0);
  tissue.attenuation_db_per_cm_mhz = tissue.attenuation_along_fibres_db_per_cm_mhz = 0.3;
  const DisplayBlock block(tissue);
  const acoustics::Probe probe = TargetProbe();
  for (const bool harmonic : {false, true}) {
    ApertureOptions options = ApertureSpeckle();
    options.mean_speckle = true;
    options.display.second_harmonic = harmonic;
    ApertureRenderer renderer(block.tissue(), probe, options);
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 50.0), std::nullopt, image, 1);
    std::vector<double> depth_mm;
    std::vector<double> level_db;
    for (int k = 60; k < 360; ++k) {
      depth_mm.push_back(k * renderer.grid().step_mm);
      level_db.push_back(
          10.0 * std::log10(testing_support::MeanIntensity(renderer.envelope(), k, 20, 108)));
    }
    const double mhz = harmonic ? 10.0 : 5.0;
    const double expected = -2.0 * 0.3 * mhz * 0.1;  // dB per mm, both ways.
    EXPECT_NEAR(StraightLine(depth_mm, level_db).slope, expected, 0.02 * std::abs(expected));
  }
}

/// Mean grey of a row of the image.
double GreyAt(const image::GrayImage& image, int row) {
  double sum = 0.0;
  for (int c = image.width / 4; c < 3 * image.width / 4; ++c) sum += image.At(c, row);
  return sum / (image.width / 2.0);
}

TEST(UltrasoundHarmonic, BuildsUpToTheFocus) {
  const DisplayBlock block(Scattering(-20.0));
  acoustics::Probe probe = TargetProbe();
  probe.dynamic_range_db = 80.0;
  ApertureOptions options = ApertureSpeckle();
  options.mean_speckle = true;
  const auto greys = [&](bool harmonic) {
    options.display.second_harmonic = harmonic;
    ApertureRenderer renderer(block.tissue(), probe, options);
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 50.0), std::nullopt, image, 1);
    return image;
  };
  const image::GrayImage fundamental = greys(false);
  const image::GrayImage harmonic = greys(true);
  const double mm_per_px = acoustics::ImageOf(probe).axial_mm_per_px;
  for (const double depth_mm : {4.0, 10.0, 20.0, 30.0}) {
    const int row = static_cast<int>(std::lround(depth_mm / mm_per_px));
    const double change_db = (GreyAt(harmonic, row) - GreyAt(fundamental, row)) * 80.0 / 255.0;
    EXPECT_NEAR(change_db, 20.0 * std::log10(std::min(1.0, depth_mm / 20.0)), 0.5) << depth_mm;
  }
}

TEST(UltrasoundHarmonic, NoiseIsNearerByTheLevelOfTheHarmonic) {
  const DisplayBlock block(Clear());
  const acoustics::Probe probe = TargetProbe();
  ApertureOptions options = ApertureSpeckle();
  options.noise = true;
  const auto noise_db = [&](bool harmonic) {
    options.display.second_harmonic = harmonic;
    options.display.harmonic_db = -23.0;
    ApertureRenderer renderer(block.tissue(), probe, options);
    image::GrayImage image;
    double sum = 0.0;
    for (int n = 0; n < 8; ++n) {
      renderer.Render(FaceAt(15.0, 0.5 - 0.01 * n, 50.0), std::nullopt, image, 1);
      // Behind the focus, where nothing builds up any more.
      for (int k = 240; k < 360; ++k) {
        sum += testing_support::MeanIntensity(renderer.envelope(), k, 0, 129);
      }
    }
    return 10.0 * std::log10(sum);
  };
  EXPECT_NEAR(noise_db(true) - noise_db(false), 23.0, 0.5);
}

TEST(UltrasoundHarmonic, SideLobesAreWeaker) {
  acoustics::Probe probe = TargetProbe();
  acoustics::Probe harmonic = probe;
  harmonic.second_harmonic = true;
  for (const double sine : {0.3, 0.45, 0.6}) {
    EXPECT_LT(LobeIntensity(harmonic, Apodisation::kRectangular, 20.0, sine),
              0.1 * LobeIntensity(probe, Apodisation::kRectangular, 20.0, sine))
        << sine;
  }
  EXPECT_NEAR(LobeIntensity(harmonic, Apodisation::kRectangular, 20.0, 0.0), 1.0, 1e-9);
}

DisplayOptions Everything() {
  DisplayOptions display;
  display.curve = GreyCurve::kSigmoid;
  display.curve_parameter = 1.1;
  display.compound_angles = 3;
  display.compound_span_rad = 0.3;
  display.edge_strength = 0.7;
  display.second_harmonic = true;
  return display;
}

template <typename Renderer, typename Options>
void ExpectTheSameBits(Options options) {
  const DisplayBlock block(Scattering());
  options.display = Everything();
  for (const auto kind : {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    acoustics::Probe probe = TargetProbe();
    probe.kind = kind;
    probe.gain_db = 25.0;
    if (kind == acoustics::ProbeKind::kCurvilinear) {
      probe.radius_mm = 40.0;
      probe.field_of_view_rad = 0.6;
    }
    std::vector<std::uint8_t> first;
    for (const int threads : {1, 2, 4}) {
      Renderer renderer(block.tissue(), probe, options);
      image::GrayImage image;
      renderer.Render(FaceAt(15.0, 0.5, 50.0), std::nullopt, image, threads);
      renderer.Render(FaceAt(15.0, 0.5, 40.0), std::nullopt, image, threads);
      if (first.empty()) first = image.pixels;
      EXPECT_EQ(image.pixels, first) << threads;
      EXPECT_GT(*std::ranges::max_element(first), 60);
    }
  }
}

TEST(UltrasoundDisplay, TheBitsDoNotDependOnTheThreads) {
  ExpectTheSameBits<BeamRenderer>(BeamOptions());
  ExpectTheSameBits<ApertureRenderer>(ApertureOptions());
}

TEST(UltrasoundDisplay, RefractionAndSteeringExcludeEachOther) {
  const DisplayBlock block(Scattering());
  ApertureOptions options;
  options.display.compound_angles = 3;
  options.display.compound_span_rad = 0.2;
  options.refraction = true;
  EXPECT_THAT([&] { ApertureRenderer(block.tissue(), TargetProbe(), options); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("compound_angles 1")));
}

}  // namespace
}  // namespace acus::ultrasound
