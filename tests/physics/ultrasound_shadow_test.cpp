// Bone, gas and needle in images with a known truth: where the lines are, and how dark it is
// below.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>

#include "acus/base/core/random.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

/// 0.1 mm per pixel, 512 columns wide and as deep.
acoustics::Probe FineProbe() {
  return {.name = "test",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 10,
          .width_mm = 51.2,
          .depth_mm = 51.1,
          .image_width_px = 512,
          .image_height_px = 512,
          .slice_thickness_mm = 3,
          .pulse_length_mm = 0.7,
          .beam_width_mm = 1.2,
          .dynamic_range_db = 60,
          .gain_db = 4};
}

/// Soft tissue with the noise of a CT, skin at y = 5 mm, and something in it.
template <typename Content>
volume::CtVolume Body(const Content& content) {
  RandomStream random(11, "noise");
  return testing_support::SyntheticCt({140, 140, 60}, 0.5, [&](double x, double y, double z) {
    const double noise = 8.0 * random.Normal();
    const std::optional<double> hu = content(x, y, z);
    return y < 5.0 ? -1000.0 : hu.value_or(50.0 + noise);
  });
}

volume::CtVolume PlainBody() {
  return Body([](double, double, double) { return std::optional<double>(); });
}

/// Middle of the front, so that pixel column c is at x = 9.4 + 0.1 c, row r at y = 5 + 0.1 r.
Eigen::Isometry3d Pose() {
  return Eigen::Isometry3d(Eigen::Translation3d(34.95, 5.0, 15.0));
}

image::GrayImage Render(const volume::CtVolume& ct,
                        const std::optional<image::NeedleInImage>& needle,
                        const acoustics::Probe& probe = FineProbe()) {
  BModeRenderer renderer(ct, probe, DefaultBModeOptions());
  image::GrayImage image;
  renderer.Render(Pose(), needle, image);
  return image;
}

double Mean(const image::GrayImage& image, int c0, int c1, int r0, int r1) {
  double sum = 0.0;
  for (int r = r0; r < r1; ++r) {
    for (int c = c0; c < c1; ++c) sum += image.At(c, r);
  }
  return sum / ((c1 - c0) * (r1 - r0));
}

/// Grey per decibel in the upper part of the curve.
constexpr double kGreyPerDb = 255.0 / 60.0;

TEST(Shadow, ABonePlateIsABrightLineAtItsDepthWithNothingBelow) {
  const volume::CtVolume ct = Body([](double x, double y, double) {
    const bool plate = y >= 25.0 && y <= 35.0 && x > 30.0 && x < 45.0;
    return plate ? std::optional(1200.0) : std::nullopt;
  });
  const image::GrayImage image = Render(ct, std::nullopt);
  // The surface lies between the voxels at 24.5 (soft) and 25 mm: rows 195 to 200.
  for (int c = 240; c < 320; c += 10) {
    int brightest = 0;
    for (int r = 0; r < 512; ++r) {
      if (image.At(c, r) > image.At(c, brightest)) brightest = r;
    }
    EXPECT_GE(image.At(c, brightest), 250) << "column " << c;
    EXPECT_NEAR(brightest, 197.5, 6) << "column " << c;
  }
  // At least 40 dB darker than the same depth beside the plate, or black.
  const double shadow = Mean(image, 230, 330, 300, 500);
  const double beside = Mean(image, 20, 150, 300, 500);
  EXPECT_GT(beside, 20.0);
  EXPECT_LE(shadow, std::max(1.0, beside - 40.0 * kGreyPerDb));
}

TEST(Shadow, GasShadowsAsWellAndWaterDoesNot) {
  for (const auto& [content_hu, shadows] : {std::pair{-950.0, true}, {15.0, false}}) {
    const double hu = content_hu;
    const volume::CtVolume ct = Body([hu](double x, double y, double) {
      return std::hypot(x - 35.0, y - 25.0) < 6.0 ? std::optional(hu) : std::nullopt;
    });
    const image::GrayImage image = Render(ct, std::nullopt);
    const double below = Mean(image, 240, 270, 320, 500);
    const double beside = Mean(image, 20, 120, 320, 500);
    if (shadows) {
      EXPECT_LE(below, 1.0);
    } else {
      EXPECT_NEAR(below, beside, 0.15 * beside);
      EXPECT_LT(Mean(image, 240, 270, 180, 220), 0.2 * beside) << "water has no echo of its own";
    }
  }
}

image::NeedleInImage InPlaneNeedle() {
  image::NeedleInImage needle;
  needle.tip_in_ct_mm << 40.0, 30.0, 15.0;
  needle.axis_in_ct = Eigen::Vector3d(1.0, 0.8, 0.0).normalized();
  needle.length_mm = 90.0;
  needle.radius_mm = 0.4;
  return needle;
}

/// Where a trainee sees the tip: the bright pixel farthest along the needle's axis.
template <typename IsBright>
Eigen::Vector2d FarthestBright(const image::NeedleInImage& needle, const IsBright& is_bright) {
  double farthest = -1e9;
  Eigen::Vector2d tip(-1, -1);
  for (int r = 0; r < 512; ++r) {
    for (int c = 0; c < 512; ++c) {
      const double along = c * needle.axis_in_ct.x() + r * needle.axis_in_ct.y();
      if (along > farthest && is_bright(c, r)) {
        farthest = along;
        tip = {c, r};
      }
    }
  }
  return tip;
}

TEST(NeedleInImage, ItsTipIsWithinOnePixelOfTheTruth) {
  const volume::CtVolume ct = PlainBody();
  slicing::CtSliceRenderer slice(ct, acoustics::ImageOf(FineProbe()), 3.0);
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0, 0), Eigen::Vector2d(-3.03, 5.07)}) {
    image::NeedleInImage needle = InPlaneNeedle();
    needle.tip_in_ct_mm.head<2>() += shift;
    image::GrayImage image;
    slice.Render(Pose(), needle, image);
    const Eigen::Vector3d truth =
        slice.image().ct_from_image(Pose()).inverse() * needle.tip_in_ct_mm;
    const Eigen::Vector2d in_slice =
        FarthestBright(needle, [&](int c, int r) { return slice.hu().row(r)[c] == 4000.0F; });
    EXPECT_LE((in_slice - truth.head<2>()).norm(), 1.0);

    // With a pulse, a beam and an interface of one pixel, B-mode is as exact.
    acoustics::Probe sharp = FineProbe();
    sharp.pulse_length_mm = sharp.beam_width_mm = 0.0;
    BModeOptions options = DefaultBModeOptions();
    options.interface_span_mm = 0.0;
    BModeRenderer renderer(ct, sharp, options);
    renderer.Render(Pose(), needle, image);
    const Eigen::Vector2d seen =
        FarthestBright(needle, [&](int c, int r) { return image.At(c, r) >= 230; });
    EXPECT_LE((seen - truth.head<2>()).norm(), 1.0);
  }
}

TEST(NeedleInImage, InThePlaneItIsALineWithAShadow) {
  const image::GrayImage image = Render(PlainBody(), InPlaneNeedle());
  // Along the shaft, from the tip at pixel (306, 250) backwards.
  for (int n = 20; n < 250; n += 5) {
    const int c = 306 - n;
    const int r = 250 - static_cast<int>(std::lround(0.8 * n));
    ASSERT_GT(r, 10);
    int brightest = 0;
    for (int d = -9; d <= 3; ++d) brightest = std::max<int>(brightest, image.At(c, r + d));
    EXPECT_GE(brightest, 240) << "column " << c;
    EXPECT_LE(Mean(image, c - 2, c + 3, r + 40, 512), 1.0) << "column " << c;
  }
  EXPECT_GT(Mean(image, 330, 480, 300, 500), 20.0);  // Beyond the tip: tissue.
}

TEST(NeedleInImage, AcrossThePlaneItIsOneSpot) {
  image::NeedleInImage needle = InPlaneNeedle();
  needle.axis_in_ct << 0, 0, 1;
  needle.tip_in_ct_mm << 35.0, 25.0, 25.0;
  const image::GrayImage image = Render(PlainBody(), needle);
  int bright = 0;
  double column = 0.0;
  for (int r = 0; r < 512; ++r) {
    for (int c = 0; c < 512; ++c) {
      if (image.At(c, r) < 230) continue;
      ++bright;
      column += c;
      EXPECT_LE(std::hypot(c - 256, r - 200), 20.0);
    }
  }
  ASSERT_GT(bright, 20);
  EXPECT_NEAR(column / bright, 256.0, 1.5);
}

TEST(NeedleInImage, OutOfThePlaneItChangesNoPixel) {
  const volume::CtVolume ct = PlainBody();
  const image::GrayImage without = Render(ct, std::nullopt);
  image::NeedleInImage needle = InPlaneNeedle();
  for (const double aside_mm : {1.95, -1.95, 10.0}) {  // Half the slice and the radius are 1.9 mm.
    needle.tip_in_ct_mm.z() = 15.0 + aside_mm;
    EXPECT_EQ(Render(ct, needle).pixels, without.pixels) << aside_mm;
  }
  needle.tip_in_ct_mm.z() = 15.0 + 1.85;
  EXPECT_NE(Render(ct, needle).pixels, without.pixels);
}

TEST(NeedleInImage, AThinnerSliceShowsLessOfAnObliqueNeedle) {
  const volume::CtVolume ct = PlainBody();
  image::NeedleInImage needle = InPlaneNeedle();
  needle.axis_in_ct = Eigen::Vector3d(1.0, 0.8, 0.3).normalized();
  needle.tip_in_ct_mm.z() += 3.0;
  const auto seen_px = [&](double thickness_mm) {
    slicing::CtSliceRenderer slice(ct, acoustics::ImageOf(FineProbe()), thickness_mm);
    image::GrayImage image;
    slice.Render(Pose(), needle, image);
    long n = 0;
    for (int r = 0; r < 512; ++r)
      n += std::count(slice.hu().row(r), slice.hu().row(r) + 512, 4000.0F);
    return n;
  };
  EXPECT_GT(seen_px(0.0), 0);
  EXPECT_LT(seen_px(0.0), seen_px(2.0));
  EXPECT_LT(seen_px(2.0), seen_px(5.0));
}

TEST(Sampling, AnInterfaceIsAsBrightHoweverFinelyTheBeamIsSampled) {
  // Blurred, as every CT is: with neighbouring samples alone it would fade 6 dB per halved step.
  const auto ct = testing_support::SyntheticCt({140, 140, 60}, 0.5, [](double, double y, double) {
    return y < 5.0 ? -1000.0 : 20.0 + 60.0 / (1.0 + std::exp(-(y - 25.0) / 0.3));
  });
  std::vector<int> peaks;
  for (const int pixels : {256, 512, 1024}) {
    acoustics::Probe probe = FineProbe();
    probe.image_width_px = probe.image_height_px = pixels;
    probe.beam_width_mm = 0.0;
    const image::GrayImage image = Render(ct, std::nullopt, probe);
    int peak = 0;
    for (int r = pixels / 4; r < pixels; ++r) peak = std::max<int>(peak, image.At(pixels / 2, r));
    peaks.push_back(peak);
  }
  EXPECT_GT(peaks[0], 50);
  EXPECT_NEAR(peaks[1], peaks[0], 0.5 * kGreyPerDb);
  EXPECT_NEAR(peaks[2], peaks[0], 0.5 * kGreyPerDb);
}

}  // namespace
}  // namespace acus::ultrasound
