#include "acus/imaging/ultrasound/display/display.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

acoustics::Probe Linear() {
  return {.name = "test",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 10,
          .width_mm = 20,
          .depth_mm = 25.4,
          .image_width_px = 128,
          .image_height_px = 128,
          .dynamic_range_db = 60};
}

slicing::BeamImage Echo(const acoustics::ScanGrid& grid, float value) {
  slicing::BeamImage echo;
  echo.Resize(grid.lines(), grid.samples);
  for (int k = 0; k < grid.samples; ++k)
    std::fill_n(echo.row(k), echo.stride() - 2 * slicing::BeamImage::kMargin, value);
  return echo;
}

TEST(HalfHanning, IsARaisedCosineOfUnitSum) {
  const std::vector<float> half = HalfHanning(1.0, 0.1, 32);
  ASSERT_EQ(half.size(), 5U);
  double sum = half[0];
  for (std::size_t t = 1; t < half.size(); ++t) {
    sum += 2.0 * half[t];
    EXPECT_NEAR(half[t] / half[0],
                0.5 * (1.0 + std::cos(2.0 * M_PI * 0.1 * static_cast<double>(t))), 1e-6);
  }
  EXPECT_NEAR(sum, 1.0, 1e-6);
  EXPECT_EQ(HalfHanning(0.0, 0.1, 32), std::vector<float>{1.0F});
  EXPECT_EQ(HalfHanning(0.2, 0.1, 32), std::vector<float>{1.0F});
  EXPECT_EQ(HalfHanning(1.0, 0.1, 4).size(), 5U);
  EXPECT_THROW(HalfHanning(1.0, 0.1, 3), InputError);
}

TEST(EchoDisplay, GreyIsTheLogarithmOfTheIntensity) {
  const acoustics::Probe probe = Linear();
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  EchoDisplay display(probe, grid);
  for (const double db : {0.0, -10.0, -30.0, -50.0, -60.0, -90.0}) {
    image::GrayImage image;
    display.Show(Echo(grid, static_cast<float>(std::pow(10.0, db / 10.0))), image, 1);
    const double expected = 255.0 * std::log1p(1e6 * std::pow(10.0, db / 10.0)) / std::log1p(1e6);
    EXPECT_NEAR(image.At(64, 60), expected, 0.51) << db << " dB";
  }
}

TEST(EchoDisplay, GainMovesDecibelsAndTimeGainGrowsWithDepth) {
  acoustics::Probe probe = Linear();
  probe.gain_db = 10;
  probe.tgc_db_per_cm = 5;
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  EchoDisplay display(probe, grid);
  image::GrayImage image;
  display.Show(Echo(grid, 1e-4F), image, 1);
  for (const int row : {0, 50, 100}) {
    const double db = -40.0 + 10.0 + 5.0 * row * grid.step_mm / 10.0;
    EXPECT_NEAR(image.At(64, row),
                255.0 * std::log1p(1e6 * std::pow(10.0, db / 10.0)) / std::log1p(1e6), 0.51);
  }
}

TEST(EchoDisplay, APointSpreadsByTheWindows) {
  acoustics::Probe probe = Linear();
  probe.pulse_length_mm = 1.6;
  probe.beam_width_mm = 2.4;
  probe.dynamic_range_db = 30;
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  EchoDisplay display(probe, grid);
  slicing::BeamImage echo = Echo(grid, 0.0F);
  echo.row(60)[40] = 0.5F;
  image::GrayImage image;
  display.Show(echo, image, 1);
  const int column = 40 + (128 - grid.lines()) / 2;
  double sum = 0.0;
  int widest = 0;
  int tallest = 0;
  for (int r = 0; r < 128; ++r) {
    for (int c = 0; c < 128; ++c) {
      sum += std::expm1(image.At(c, r) / 255.0 * std::log1p(1000.0)) / 1000.0;
      if (image.At(c, r) > 0) widest = std::max(widest, std::abs(c - column));
      if (image.At(c, r) > 0) tallest = std::max(tallest, std::abs(r - 60));
    }
  }
  EXPECT_NEAR(sum, 0.5 * 0.5 * 1.6 / grid.step_mm, 0.05);  // A Hanning window of peak 1.
  EXPECT_EQ(image.At(column, 60), *std::max_element(image.pixels.begin(), image.pixels.end()));
  EXPECT_LE(tallest, 4);  // Half of 1.6 mm in steps of 0.2 mm.
  EXPECT_LE(widest, 6);   // Half of 2.4 mm.
  EXPECT_GE(widest, 4);
}

TEST(EchoDisplay, SidesAndRowsBelowTheDepthAreBlack) {
  acoustics::Probe probe = Linear();
  probe.depth_mm = 10;  // Square pixels: the width decides, and the rest of the height is empty.
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  EchoDisplay display(probe, grid);
  image::GrayImage image;
  image.Resize(128, 128);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{77});  // Of an earlier image.
  display.Show(Echo(grid, 1.0F), image, 1);
  EXPECT_EQ(image.At(64, 0), 255);
  EXPECT_EQ(image.At(64, grid.samples - 1), 255);
  for (int c = 0; c < 128; ++c) EXPECT_EQ(image.At(c, grid.samples), 0);
  probe = Linear();
  const acoustics::ScanGrid narrow = acoustics::ScanGridOf(probe);
  image::GrayImage sides;
  EchoDisplay(probe, narrow).Show(Echo(narrow, 1.0F), sides, 1);
  const int left = (128 - narrow.lines()) / 2;
  EXPECT_EQ(sides.At(left - 1, 5), 0);
  EXPECT_EQ(sides.At(left, 5), 255);
  EXPECT_EQ(sides.At(127 - left, 5), 255);
  EXPECT_EQ(sides.At(128 - left, 5), 0);
}

TEST(EchoDisplay, AFanPutsEachEchoWhereItIs) {
  acoustics::Probe probe = Linear();
  probe.kind = acoustics::ProbeKind::kCurvilinear;
  probe.scan_lines = 90;
  probe.radius_mm = 40;
  probe.field_of_view_rad = 1.1;
  probe.depth_mm = 80;
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(probe);
  const image::ImageGeometry geometry = acoustics::ImageOf(probe);
  EchoDisplay display(probe, grid);
  for (const auto& [line, sample] : {std::pair{5, 60}, {45, 20}, {80, 75}}) {
    slicing::BeamImage echo = Echo(grid, 0.0F);
    echo.row(sample)[line] = 1.0F;
    image::GrayImage image;
    display.Show(echo, image, 1);
    const Eigen::Vector2d at = grid.start_mm[line] + sample * grid.step_mm * grid.direction[line];
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double weight = 0.0;
    for (int r = 0; r < 128; ++r) {
      for (int c = 0; c < 128; ++c) {
        const Eigen::Vector3d mm = geometry.probe_from_image() * Eigen::Vector3d(c, r, 0);
        centre += image.At(c, r) * mm.head<2>();
        weight += image.At(c, r);
      }
    }
    ASSERT_GT(weight, 0.0) << line;
    EXPECT_LT((centre / weight - at).norm(), 0.6 * geometry.axial_mm_per_px) << line;
  }
  image::GrayImage full;
  display.Show(Echo(grid, 1.0F), full, 1);
  EXPECT_EQ(full.At(64, 70), 255);
  EXPECT_EQ(full.At(0, 0), 0);      // Beside the face.
  EXPECT_EQ(full.At(127, 127), 0);  // Beyond the arc.
}

TEST(EchoDisplay, RefusesAWindowThatIsTooWide) {
  acoustics::Probe probe = Linear();
  probe.beam_width_mm = 20;
  EXPECT_THROW(EchoDisplay(probe, acoustics::ScanGridOf(probe)), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
