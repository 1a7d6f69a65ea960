// The aperture model against closed forms: smooth interfaces, losses, speckle, contact, texture.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/columns/ct_texture.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Clear;
using testing_support::Db;
using testing_support::FaceAt;
using testing_support::Fit;
using testing_support::LabelledBlock;
using testing_support::MeanIntensity;
using testing_support::Scattering;
using testing_support::StraightLine;
using testing_support::TableOf;
using testing_support::TargetProbe;

/// Interfaces and losses only.
ApertureOptions ApertureBare() {
  ApertureOptions options;
  options.speckle = options.texture = options.clutter = options.noise = options.ring_down = false;
  options.comet_tail = false;
  options.rough_layer_mm = 0.0;  // Mirrors.
  return options;
}

struct ApertureBlock {
  volume::LabelMap labels;
  acoustics::TissueAcousticsTable table;

  BeamTissue tissue() const { return {.labels = &labels, .acoustics = &table}; }
};

/// Impedances 1.5 and 1.7 on both sides of a plane through (32, 32, 32) mm, whose normal is turned
/// from y by an angle in the image plane.
ApertureBlock AperturePlaneAt(double turn_rad, double spacing_mm) {
  const int voxels = static_cast<int>(64.0 / spacing_mm);
  ApertureBlock block{LabelledBlock({voxels, voxels, voxels}, spacing_mm, {{1, "near"}, {2, "far"}},
                                    [&](double x, double y, double) {
                                      const double beyond = (y - 32.0) * std::cos(turn_rad) +
                                                            (x - 32.0) * std::sin(turn_rad);
                                      return static_cast<volume::Label>(beyond > 0.0 ? 2 : 1);
                                    }),
                      TableOf({{"near", Clear(1540.0, 1.5)}, {"far", Clear(1540.0, 1.7)}})};
  return block;
}

/// Largest amplitude of each line around the middle, in the order of lines.
std::vector<double> AperturePeaks(ApertureRenderer& renderer, int half_lines) {
  const slicing::BeamImage& envelope = renderer.envelope();
  const int middle = renderer.grid().lines() / 2;
  std::vector<double> peaks;
  for (int l = middle - half_lines; l <= middle + half_lines; ++l) {
    float peak = 0.0F;
    for (int k = 0; k < renderer.grid().samples; ++k) peak = std::max(peak, envelope.row(k)[l]);
    peaks.push_back(double{peak});
  }
  return peaks;
}

TEST(UltrasoundAperture, AFlatInterfaceReturnsItsReflection) {
  const ApertureBlock block = AperturePlaneAt(0.0, 0.5);
  ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureBare());
  image::GrayImage image;
  renderer.Render(FaceAt(32.0, 12.0, 32.0), {}, image);
  const double reflection = 0.2 / 3.2;
  for (const double peak : AperturePeaks(renderer, 30)) {
    EXPECT_NEAR(Db(peak), Db(reflection), 0.2);
  }
}

// The plane and the probe turn together: only the voxel grid lies otherwise. The level is the mean
// over lines of the peak's intensity; single lines keep what is left of the stairs.
TEST(UltrasoundAperture, TheEchoOfAPlaneDoesNotKnowTheVoxelGrid) {
  const double reflection = 0.2 / 3.2;
  for (const double spacing_mm : {0.5, 0.8}) {
    for (int degrees = 0; degrees <= 90; degrees += 5) {
      const double turn = degrees * std::numbers::pi / 180.0;
      const ApertureBlock block = AperturePlaneAt(turn, spacing_mm);
      ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureBare());
      const Eigen::Vector2d face =
          Eigen::Vector2d(32.0, 32.0) - 15.0 * Eigen::Vector2d(std::sin(turn), std::cos(turn));
      image::GrayImage image;
      renderer.Render(FaceAt(face.x(), face.y(), 32.0, turn), {}, image);
      double intensity = 0.0;
      for (const double peak : AperturePeaks(renderer, 30)) {
        intensity += peak * peak / 61.0;
        EXPECT_NEAR(Db(peak), Db(reflection), 3.0) << degrees << " degrees, " << spacing_mm;
      }
      EXPECT_NEAR(Db(std::sqrt(intensity)), Db(reflection), 1.0)
          << degrees << " degrees, " << spacing_mm;
    }
  }
}

TEST(UltrasoundAperture, TheEchoLiesWhereThePlaneIs) {
  for (const double spacing_mm : {0.5, 1.0}) {
    const ApertureBlock block = AperturePlaneAt(0.0, spacing_mm);
    ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureBare());
    image::GrayImage image;
    for (const double face_mm : {10.0, 12.03, 14.07}) {
      renderer.Render(FaceAt(32.0, face_mm, 32.0), {}, image);
      const slicing::BeamImage& envelope = renderer.envelope();
      const int middle = renderer.grid().lines() / 2;
      int best = 0;
      for (int k = 0; k < renderer.grid().samples; ++k) {
        if (envelope.row(k)[middle] > envelope.row(best)[middle]) best = k;
      }
      // One and a half samples, a seventh of the larger voxel.
      EXPECT_NEAR(best * renderer.grid().step_mm, 32.0 - face_mm, 0.15) << spacing_mm;
    }
  }
}

ApertureBlock ApertureUniform(const acoustics::TissueAcoustics& tissue) {
  return {LabelledBlock({100, 100, 60}, 0.6, {{1, "tissue"}},
                        [](double, double, double) { return volume::Label{1}; }),
          TableOf({{"tissue", tissue}})};
}

TEST(UltrasoundAperture, AttenuationAndSpeckleAreThoseOfTheTissue) {
  acoustics::TissueAcoustics tissue = Scattering(-30.0);
  tissue.attenuation_db_per_cm_mhz = 0.7;
  const ApertureBlock block = ApertureUniform(tissue);
  ApertureOptions options = ApertureBare();
  options.speckle = true;
  std::vector<double> depth_cm;
  std::vector<double> sum(40, 0.0);
  double amplitude = 0.0;
  double squares = 0.0;
  int count = 0;
  const acoustics::Probe probe = TargetProbe();
  ApertureRenderer renderer(block.tissue(), probe, options);
  for (int pose = 0; pose < 12; ++pose) {
    image::GrayImage image;
    renderer.Render(FaceAt(30.0, 6.0, 8.0 + 2.0 * pose), {}, image);
    const slicing::BeamImage& envelope = renderer.envelope();
    for (int n = 0; n < 40; ++n) {
      for (int k = 0; k < 5; ++k) {
        sum[static_cast<std::size_t>(n)] += MeanIntensity(envelope, 50 + 8 * n + k, 5, 124) / 60.0;
      }
    }
    for (int k = 180; k < 230; ++k) {
      const double level = std::pow(10.0, -0.7 * 5.0 * 2.0 * 0.01 * k / 20.0);
      for (int l = 5; l < 124; ++l) {
        const double value = double{envelope.row(k)[l]} / level;
        amplitude += value;
        squares += value * value;
        ++count;
      }
    }
  }
  std::vector<double> db;
  for (int n = 0; n < 40; ++n) {
    depth_cm.push_back(0.01 * (52 + 8 * n));
    db.push_back(10.0 * std::log10(sum[static_cast<std::size_t>(n)]));
  }
  const Fit line = StraightLine(depth_cm, db);
  EXPECT_NEAR(line.slope, -7.0, 0.02 * 7.0);
  const double mean = amplitude / count;
  const double variance = squares / count - mean * mean;
  EXPECT_NEAR(mean / std::sqrt(variance), 1.913, 0.06);
  const double pulse_mm =
      acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe)) * std::sqrt(std::numbers::pi);
  EXPECT_NEAR(10.0 * std::log10(squares / count), -30.0 + 10.0 * std::log10(pulse_mm), 0.3);
}

TEST(UltrasoundAperture, AShadowFadesInBelowBoneAndIsFilledByHaze) {
  acoustics::TissueAcoustics bone = Clear(4080.0, 7.8);
  bone.backscatter_db = -40.0;
  const ApertureBlock block{
      LabelledBlock({100, 100, 60}, 0.6, {{1, "tissue"}, {2, "bone"}},
                    [](double, double y, double) {
                      return static_cast<volume::Label>(y > 24.0 && y < 30.0 ? 2 : 1);
                    }),
      TableOf({{"tissue", Scattering(-45.0)}, {"bone", bone}})};
  ApertureOptions options = ApertureBare();
  options.speckle = true;
  ApertureRenderer dark(block.tissue(), TargetProbe(), options);
  options.clutter = true;
  ApertureRenderer filled(block.tissue(), TargetProbe(), options);
  image::GrayImage image;
  const auto level = [&](ApertureRenderer& renderer, double depth_mm) {
    renderer.Render(FaceAt(30.0, 4.0, 18.0), {}, image);
    const int k = static_cast<int>(std::lround(depth_mm / 0.1));
    double sum = 0.0;
    for (int n = k - 8; n <= k + 8; ++n)
      sum += MeanIntensity(renderer.envelope(), n, 5, 124) / 17.0;
    return 10.0 * std::log10(sum + 1e-30);
  };
  const double above = level(filled, 15.0);
  EXPECT_LT(level(dark, 32.0), above - 80.0);
  // Haze: far below tissue, and falling with depth.
  EXPECT_LT(level(filled, 30.0), above - 15.0);
  EXPECT_GT(level(filled, 30.0), above - 60.0);
  EXPECT_LT(level(filled, 36.0), level(filled, 30.0));
}

TEST(UltrasoundAperture, BeyondTheVolumeNothingComesBack) {
  const ApertureBlock block = ApertureUniform(Scattering(-30.0));
  ApertureOptions options = ApertureBare();
  options.speckle = true;
  ApertureRenderer renderer(block.tissue(), TargetProbe(), options);
  image::GrayImage image;
  // The block ends at 60 mm: 20 mm below the face.
  renderer.Render(FaceAt(30.0, 40.0, 18.0), {}, image);
  EXPECT_GT(MeanIntensity(renderer.envelope(), 150, 5, 124), 1e-5);
  for (int k = 225; k < 400; k += 25) {
    EXPECT_LT(MeanIntensity(renderer.envelope(), k, 5, 124), 1e-12) << k;
  }
}

/// A CT of one grey, with air above y = 10 mm on one half.
TEST(UltrasoundAperture, AFaceThatLooksIntoAirHasNoContact) {
  volume::Geometry geometry;
  geometry.size = {100, 100, 60};
  geometry.spacing_mm.setConstant(0.6);
  geometry.origin_mm.setConstant(0.3);
  volume::CtVolume ct(geometry, std::int16_t{50});
  for (int k = 0; k < 60; ++k) {
    for (int j = 0; j < 34; ++j) {
      for (int i = 0; i < 100; ++i) ct.At(i, j, k) = i < 50 ? -1000 : 50;
    }
  }
  acoustics::TissueAcousticsTable table =
      TableOf({{"tissue", Scattering(-30.0)}, {"air", Clear(343.0, 0.0004)}});
  table.by_hu = {{-1000.0, "air"}, {-300.0, "air"}, {0.0, "tissue"}, {100.0, "tissue"}};
  const BeamTissue tissue{.ct = &ct, .acoustics = &table};
  ApertureOptions options = ApertureBare();
  options.speckle = true;
  ApertureRenderer renderer(tissue, TargetProbe(), options);
  image::GrayImage image;
  renderer.Render(FaceAt(30.0, 8.0, 18.0), {}, image);  // 12.4 mm of air on one side.
  const double without = MeanIntensity(renderer.envelope(), 250, 2, 30);
  const double with = MeanIntensity(renderer.envelope(), 250, 98, 126);
  EXPECT_GT(with, 1e-5);
  EXPECT_LT(without, 1e-3 * with);
  // Gel fills a gap that is narrow enough.
  renderer.Render(FaceAt(30.0, 17.0, 18.0), {}, image);
  EXPECT_GT(MeanIntensity(renderer.envelope(), 250, 2, 30), 0.3 * with);
}

TEST(UltrasoundAperture, ContrastFilledVesselsAreDarkAndNoiseOfTheCtIsNot) {
  EXPECT_EQ(TextureDb(0.0), 0.0);
  EXPECT_LE(TextureDb(60.0), -10.0);
  EXPECT_GT(TextureDb(-60.0), 0.0);
  const auto labels = LabelledBlock({80, 80, 40}, 0.8, {{8, "liver"}},
                                    [](double, double, double) { return volume::Label{8}; });
  volume::CtVolume ct(labels.geometry, std::int16_t{110});
  std::uint32_t state = 1;
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 80; ++j) {
      for (int i = 0; i < 80; ++i) {
        state = state * 1664525U + 1013904223U;
        const int noise = static_cast<int>(state >> 26) - 32;
        const bool vessel = std::hypot(0.8 * (i - 40), 0.8 * (j - 40)) < 4.0;
        ct.At(i, j, k) = static_cast<std::int16_t>(110 + noise + (vessel ? 80 : 0));
      }
    }
  }
  const CtTexture texture(ct, labels, 2);
  const double vessel = Db(texture.GainAt(labels.geometry.Index(40, 40, 20)));
  EXPECT_LT(vessel, -12.0);
  double sum = 0.0;
  int count = 0;
  for (int i = 8; i < 26; ++i) {
    for (int j = 8; j < 72; ++j, ++count) {
      sum += std::abs(Db(texture.GainAt(labels.geometry.Index(i, j, 20))));
    }
  }
  EXPECT_LT(sum / count, 0.2);
}

TEST(UltrasoundAperture, SameBitsWithAnyNumberOfThreads) {
  const ApertureBlock block = AperturePlaneAt(0.3, 0.8);
  image::GrayImage first;
  for (const int threads : {1, 2, 4}) {
    ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureOptions(), threads);
    image::GrayImage image;
    renderer.Render(FaceAt(32.0, 12.0, 32.0), {}, image, threads);
    if (first.pixels.empty()) first = image;
    EXPECT_EQ(image.pixels, first.pixels) << threads;
  }
}

TEST(UltrasoundAperture, HardCasesEndInAnImageOrAMessage) {
  image::GrayImage image;
  for (const Eigen::Array3i& size : {Eigen::Array3i(2, 2, 2), Eigen::Array3i(1, 40, 40),
                                     Eigen::Array3i(40, 40, 1), Eigen::Array3i(3, 1, 200)}) {
    for (const volume::Label label : {volume::Label{0}, volume::Label{1}}) {
      const ApertureBlock block{
          LabelledBlock(size, 1.0, {{1, "tissue"}}, [&](double, double, double) { return label; }),
          TableOf({{"tissue", Scattering()}})};
      ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureOptions());
      renderer.Render(FaceAt(1.0, 0.0, 1.0), {}, image);
      renderer.Render(FaceAt(1e7, -1e7, 1e7), {}, image);
      EXPECT_EQ(image.pixels.size(), 256U * 400U);
    }
  }
  const ApertureBlock block = ApertureUniform(Scattering());
  ApertureRenderer renderer(block.tissue(), TargetProbe(), ApertureOptions());
  Eigen::Isometry3d broken = FaceAt(30.0, 6.0, 18.0);
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(renderer.Render(broken, {}, image), InputError);
  ApertureOptions even;
  even.aperture_rays = 4;
  EXPECT_THROW(ApertureRenderer(block.tissue(), TargetProbe(), even), InputError);
  EXPECT_THROW(ApertureRenderer({.acoustics = &block.table}, TargetProbe(), ApertureOptions()),
               InputError);
}

}  // namespace
}  // namespace acus::ultrasound
