#include "acus/imaging/ultrasound/columns/vidal.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

/// 0.5 mm per pixel, no black sides.
acoustics::Probe VidalTestProbe() {
  return {.name = "test",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 5,
          .width_mm = 64,
          .depth_mm = 63.5,
          .image_width_px = 128,
          .image_height_px = 128,
          .slice_thickness_mm = 3,
          .dynamic_range_db = 60};
}

/// Only the look-up table: grey = 0.1 + 0.8 (hu + 100) / 1000 between -100 and 900 HU.
VidalOptions TableOnly() {
  VidalOptions options = DefaultVidalOptions();
  options.grey = {{-100.0, 0.1}, {900.0, 0.9}};
  options.shadow = options.noise = options.reflections = false;
  return options;
}

template <typename Function>
volume::CtVolume Ct(const Function& hu) {
  return testing_support::SyntheticCt({96, 96, 40}, 1.0, hu);
}

/// The face along +x at y = 4 mm, beams along +y.
Eigen::Isometry3d VidalPose() {
  return Eigen::Isometry3d(Eigen::Translation3d(48, 4, 20));
}

image::GrayImage VidalImage(const volume::CtVolume& ct, const VidalOptions& options,
                            const std::optional<image::NeedleInImage>& needle = std::nullopt) {
  image::GrayImage image;
  VidalRenderer(ct, VidalTestProbe(), options).Render(VidalPose(), needle, image);
  return image;
}

TEST(Vidal, GreyIsTheTableOfTheSlice) {
  const auto ct = Ct([](double x, double, double) { return 8.0 * x; });
  VidalOptions options = TableOnly();
  const image::GrayImage image = VidalImage(ct, options);
  options.contrast = 0.5;
  options.brightness = 0.25;
  const image::GrayImage soft = VidalImage(ct, options);
  for (int c = 0; c < 128; c += 9) {
    const double x_mm = 48.0 + 0.5 * (c - 63.5);
    const double grey = 0.1 + 0.8 * (8.0 * x_mm + 100.0) / 1000.0;
    EXPECT_NEAR(image.At(c, 60), 255.0 * grey, 0.51) << c;
    EXPECT_NEAR(soft.At(c, 60), 255.0 * (0.25 + 0.5 * grey), 0.51) << c;
  }
}

TEST(Vidal, GainBrightensByItsShareOfTheDynamicRange) {
  const auto ct = Ct([](double, double, double) { return 300.0; });
  VidalOptions options = TableOnly();
  options.gain_of_table_db = 20.0;
  acoustics::Probe probe = VidalTestProbe();
  const double table = 255.0 * 0.42;
  for (const double gain_db : {14.0, 20.0, 29.0}) {
    probe.gain_db = gain_db;
    image::GrayImage image;
    VidalRenderer(ct, probe, options).Render(VidalPose(), std::nullopt, image);
    EXPECT_NEAR(image.At(64, 60), table + 255.0 * (gain_db - 20.0) / 60.0, 1.01) << gain_db;
  }
}

TEST(Vidal, WhatLiesBehindBoneOrGasIsInTheMask) {
  const auto ct = Ct([](double x, double y, double) {
    const bool plate = y >= 30.0 && y <= 32.0;
    if (plate && x < 40.0) return 600.0;
    if (plate && x > 56.0) return -900.0;
    return 50.0;
  });
  VidalOptions options = TableOnly();
  options.shadow = true;
  options.shadow_share = 0.2;
  options.surface_mm = 1.0;
  const image::GrayImage lit = VidalImage(ct, TableOnly());
  const image::GrayImage image = VidalImage(ct, options);
  const int above = 40;   // 24 mm
  const int behind = 90;  // 49 mm
  for (const int c : {20, 64, 110}) EXPECT_EQ(image.At(c, above), lit.At(c, above));
  EXPECT_EQ(image.At(64, behind), lit.At(64, behind)) << "between bone and gas";
  EXPECT_NEAR(image.At(20, behind), 0.2 * lit.At(20, behind), 0.6) << "behind bone";
  EXPECT_NEAR(image.At(110, behind), 0.2 * lit.At(110, behind), 0.6) << "behind gas";
  // The first pixels of bone itself are not behind it.
  int first = 0;
  while (lit.At(20, first) <= 255 * (0.1 + 0.8 * 0.35)) ++first;
  EXPECT_EQ(image.At(20, first + 2), lit.At(20, first + 2));
  EXPECT_LT(image.At(20, first + 3), 0.3 * lit.At(20, first + 3));
}

TEST(Vidal, NoiseIsFixedInTheBodyAndMultiplies) {
  const auto ct = Ct([](double, double, double) { return 400.0; });
  VidalOptions options = TableOnly();
  options.noise = true;
  options.noise_contrast = 0.6;
  options.noise_grain_mm = 0.5;
  VidalRenderer renderer(ct, VidalTestProbe(), options);
  image::GrayImage here;
  image::GrayImage beside;
  renderer.Render(VidalPose(), std::nullopt, here);
  // Four columns to the side the same place shows the same noise.
  renderer.Render(VidalPose() * Eigen::Translation3d(2.0, 0.0, 0.0), std::nullopt, beside);
  double sum = 0.0;
  for (int r = 0; r < 128; ++r) {
    for (int c = 0; c < 124; ++c) {
      EXPECT_NEAR(beside.At(c, r), here.At(c + 4, r), 1);
      sum += here.At(c, r);
    }
  }
  // Uniform noise n in 0 ... 1: the mean of 1 - c (1 - n) is 1 - c / 2.
  EXPECT_NEAR(sum / (128 * 124) / (255.0 * 0.5), 1.0 - 0.3, 0.02);
}

/// A step of 200 HU over 4 mm, whose normal is turned from the beam: 50 HU/mm.
volume::CtVolume Slope(double angle_rad) {
  return Ct([angle_rad](double x, double y, double) {
    const double s = std::cos(angle_rad) * (y - 36.0) + std::sin(angle_rad) * (x - 48.0);
    return 50.0 * std::clamp(s, 0.0, 4.0);
  });
}

int VidalReflectionAt(double angle_deg, const VidalOptions& options) {
  const double angle_rad = angle_deg * std::numbers::pi / 180.0;
  const volume::CtVolume ct = Slope(angle_rad);
  VidalOptions none = options;
  none.reflections = false;
  const int column = 64;
  const int row = static_cast<int>(std::lround((36.0 + 2.0 * std::cos(angle_rad) - 4.0) / 0.5));
  return VidalImage(ct, options).At(column, row) - VidalImage(ct, none).At(column, row);
}

TEST(Vidal, ReflectionsFollowSobelsGradientAlongTheBeam) {
  VidalOptions options = TableOnly();
  options.reflections = true;
  options.sobel_span_mm = 1.0;
  options.reflection_min_hu_per_mm = 20.0;
  options.reflection_full_hu_per_mm = 100.0;
  options.reflection_grey = 0.6;
  options.reflection_max_angle_rad = 40.0 * std::numbers::pi / 180.0;
  EXPECT_NEAR(VidalReflectionAt(0.0, options), 255.0 * 0.6 * 0.5, 3.0);
  EXPECT_NEAR(VidalReflectionAt(30.0, options), 255.0 * 0.6 * 0.5 * std::cos(std::numbers::pi / 6),
              3.0);
  EXPECT_EQ(VidalReflectionAt(50.0, options), 0) << "turned away";
  options.reflection_max_angle_rad = 0.5 * std::numbers::pi;
  EXPECT_NEAR(VidalReflectionAt(50.0, options),
              255.0 * 0.3 * std::cos(50.0 * std::numbers::pi / 180.0), 3.0);
  options.reflection_min_hu_per_mm = 60.0;
  EXPECT_EQ(VidalReflectionAt(0.0, options), 0) << "below the threshold";
  options.reflection_min_hu_per_mm = 5.0;
  options.reflection_full_hu_per_mm = 25.0;
  EXPECT_NEAR(VidalReflectionAt(0.0, options), 255.0 * 0.6, 3.0) << "no brighter than that";
}

TEST(Vidal, TheNeedleIsWhiteAndShadows) {
  const auto ct = Ct([](double, double, double) { return 50.0; });
  VidalOptions options = TableOnly();
  options.grey.push_back({4000.0, 1.0});
  options.shadow = true;
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = {58.0, 34.0, 20.0};
  needle.axis_in_ct = Eigen::Vector3d::UnitX();
  needle.length_mm = 20.0;
  needle.radius_mm = 0.6;
  const image::GrayImage image = VidalImage(ct, options, needle);
  const image::GrayImage bare = VidalImage(ct, options);
  EXPECT_EQ(image.At(64, 60), 255);
  EXPECT_NEAR(image.At(64, 80), options.needle_share * bare.At(64, 80), 0.6);
  EXPECT_EQ(image.At(100, 80), bare.At(100, 80));
}

TEST(Vidal, GelFillsTheGapUnderTheFace) {
  const auto ct = Ct([](double, double y, double) { return y < 10.0 ? -1000.0 : 100.0; });
  VidalOptions options = TableOnly();
  options.shadow = true;
  const image::GrayImage coupled = VidalImage(ct, options);
  options.coupling_gap_mm = 3.0;
  const image::GrayImage in_air = VidalImage(ct, options);
  EXPECT_NEAR(coupled.At(64, 60), 255.0 * (0.1 + 0.8 * 0.2), 1.0);
  EXPECT_LT(in_air.At(64, 60), 0.15 * coupled.At(64, 60));
}

TEST(Vidal, DefaultsAreThePresetAndWrongOptionsAreRefused) {
  const auto preset = ReadVidalOptions(std::filesystem::path(ACUS_SOURCE_DIR) /
                                       "configs/acoustics/vidal_2008.json");
  EXPECT_EQ(preset.grey.size(), DefaultVidalOptions().grey.size());
  const auto ct = Ct([](double, double, double) { return 0.0; });
  const auto refused = [&ct](auto&& change) {
    VidalOptions options = DefaultVidalOptions();
    change(options);
    EXPECT_THROW(VidalRenderer(ct, VidalTestProbe(), options), InputError);
  };
  refused([](VidalOptions& o) { o.grey.clear(); });
  refused([](VidalOptions& o) { o.noise_grain_mm = 0.0; });
  refused([](VidalOptions& o) { o.noise_contrast = 1.1; });
  refused([](VidalOptions& o) { o.shadow_share = -0.1; });
  refused([](VidalOptions& o) { o.reflection_full_hu_per_mm = 0.0; });
}

}  // namespace
}  // namespace acus::ultrasound
