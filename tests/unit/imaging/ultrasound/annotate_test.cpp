#include "acus/imaging/ultrasound/display/annotate.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

acoustics::Probe AnnotateTestProbe() {
  return {.name = "test",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 10,
          .width_mm = 60,
          .depth_mm = 60,
          .image_width_px = 301,
          .image_height_px = 301,
          .focus_mm = 30,
          .dynamic_range_db = 60};
}

image::GrayImage Grey(std::uint8_t grey) {
  image::GrayImage image;
  image.Resize(301, 301);
  std::fill(image.pixels.begin(), image.pixels.end(), grey);
  return image;
}

constexpr int kLeft = Screen::kScalePx;
constexpr int kTop = Screen::kTextPx;

TEST(Screen, TicksAreAtTheirDepth) {
  const Screen screen(AnnotateTestProbe(), Screen::Shows::kBMode);
  image::GrayImage out;
  screen.Compose(Grey(0), nullptr, "", out);
  // 0.2 mm per row: a tick each 25 rows, longer each second one.
  for (int r = 0; r < 301; ++r) {
    if (r > 140 && r < 160) continue;  // The focus.
    EXPECT_EQ(out.At(kLeft - 3, kTop + r) > 0, r % 25 == 0) << r;
    EXPECT_EQ(out.At(kLeft - 8, kTop + r) > 0, r % 50 == 0) << r;
  }
  EXPECT_GT(out.At(kLeft - 8, kTop + 147), 0);  // The focus, at 30 mm.
  EXPECT_EQ(out.At(kLeft - 8, kTop + 122), 0);
}

// Whatever is written, the images stay as they are.
TEST(Screen, NothingIsDrawnOnTheImages) {
  const image::GrayImage slice = Grey(90);
  const image::GrayImage b_mode = Grey(40);
  image::GrayImage out;
  Screen(AnnotateTestProbe(), Screen::Shows::kBoth)
      .Compose(b_mode, &slice, "  20.533 s    25.9 mm   0.65 N", out);
  EXPECT_EQ(out.width, 2 * (kLeft + 301));
  EXPECT_EQ(out.height, 301 + 2 * kTop);
  for (int r = 0; r < 301; ++r) {
    for (int c = 0; c < 301; ++c) {
      ASSERT_EQ(out.At(kLeft + c, kTop + r), 40) << c << ", " << r;
      ASSERT_EQ(out.At(2 * kLeft + 301 + c, kTop + r), 90) << c << ", " << r;
    }
  }
  // A ring above the right of each panel is the marked side.
  EXPECT_GT(out.At(kLeft + 301 - 1 - 12 + 5, kTop / 2), 100);
  EXPECT_GT(out.At(2 * (kLeft + 301) - 1 - 12 + 5, kTop / 2), 100);
}

// A fan that is wider than high leaves rows of a square image black.
TEST(Screen, TheSectorFillsTheFrame) {
  acoustics::Probe probe = AnnotateTestProbe();
  probe.kind = acoustics::ProbeKind::kCurvilinear;
  probe.width_mm = 0.0;
  probe.radius_mm = 60.0;
  probe.field_of_view_rad = 1.05;
  probe.depth_mm = 150.0;
  const image::ImageGeometry geometry = acoustics::ImageOf(probe);
  const Screen screen(probe, Screen::Shows::kBMode);
  const double depth_px =
      (probe.depth_mm - geometry.depth_of_top_row_mm) / geometry.axial_mm_per_px;
  EXPECT_LT(depth_px, 250.0);
  EXPECT_GE(screen.height_px() - 2 * kTop, static_cast<int>(depth_px) + 1);
  EXPECT_LE(screen.height_px() - 2 * kTop, static_cast<int>(depth_px) + 5);
}

TEST(Screen, WhatLiesBeyondTheCtIsHatchedInTheSectorOnly) {
  // Voxels of 1 mm: the CT ends 10 mm to the right of the probe's middle, and 40 mm deep.
  const ScanExtent scan{Eigen::Affine3d(Eigen::Translation3d(89.5, 0.0, 5.0)), {100, 40, 10}};
  acoustics::Probe probe = AnnotateTestProbe();
  probe.width_mm = 50.0;  // Of the image's 60 mm.
  image::GrayImage out;
  Screen(probe, Screen::Shows::kBMode).Compose(Grey(0), nullptr, "", out, &scan);
  const auto hatched = [&](int first_column, int end_column, int first_row, int end_row) {
    int count = 0;
    for (int r = first_row; r < end_row; ++r) {
      for (int c = first_column; c < end_column; ++c) count += out.At(kLeft + c, kTop + r) > 0;
    }
    return count;
  };
  EXPECT_EQ(hatched(0, 200, 0, 196), 0);                      // In the CT.
  EXPECT_NEAR(hatched(202, 270, 0, 196), 68 * 196 / 8, 40);   // To its right.
  EXPECT_NEAR(hatched(30, 200, 200, 298), 170 * 98 / 8, 40);  // Below it.
  EXPECT_EQ(hatched(277, 301, 0, 301), 0);                    // Beside the sector.
}

// A slice of the CT has neither focus nor gain.
TEST(Screen, ASliceAloneIsNotMarkedAsUltrasound) {
  image::GrayImage slice;
  image::GrayImage b_mode;
  Screen(AnnotateTestProbe(), Screen::Shows::kCtSlice).Compose(Grey(0), nullptr, "", slice);
  Screen(AnnotateTestProbe(), Screen::Shows::kBMode).Compose(Grey(0), nullptr, "", b_mode);
  EXPECT_EQ(slice.width, kLeft + 301);
  EXPECT_EQ(slice.At(kLeft - 8, kTop + 147), 0);
  EXPECT_GT(b_mode.At(kLeft - 8, kTop + 147), 0);
  // Less is written, above and below; the ring is the same.
  const auto letters = [](const image::GrayImage& image, int from_row, int to_row) {
    return std::count_if(image.pixels.begin() + from_row * image.width,
                         image.pixels.begin() + to_row * image.width,
                         [](std::uint8_t grey) { return grey > 0; });
  };
  EXPECT_LT(letters(slice, 0, kTop), letters(b_mode, 0, kTop));
  EXPECT_LT(letters(slice, kTop + 301, slice.height), letters(b_mode, kTop + 301, b_mode.height));
  EXPECT_EQ(slice.At(kLeft + 301 - 1 - 12 + 5, kTop / 2),
            b_mode.At(kLeft + 301 - 1 - 12 + 5, kTop / 2));
}

TEST(Screen, TextIsNotLeftOverFromTheFrameBefore) {
  const Screen screen(AnnotateTestProbe(), Screen::Shows::kBMode);
  image::GrayImage with;
  image::GrayImage without;
  screen.Compose(Grey(0), nullptr, "t = 1.5 s", with);
  screen.Compose(Grey(0), nullptr, "", without);
  EXPECT_NE(with.pixels, without.pixels);
  screen.Compose(Grey(0), nullptr, "", with);
  EXPECT_EQ(with.pixels, without.pixels);
}

TEST(Screen, RefusesImagesThatDoNotFit) {
  image::GrayImage out;
  const image::GrayImage slice = Grey(90);
  EXPECT_THROW(Screen(AnnotateTestProbe(), Screen::Shows::kBoth).Compose(Grey(0), nullptr, "", out),
               InputError);
  EXPECT_THROW(Screen(AnnotateTestProbe(), Screen::Shows::kBMode).Compose(Grey(0), &slice, "", out),
               InputError);
  image::GrayImage small;
  small.Resize(300, 301);
  EXPECT_THROW(Screen(AnnotateTestProbe(), Screen::Shows::kBMode).Compose(small, nullptr, "", out),
               InputError);
  EXPECT_THROW(Screen(AnnotateTestProbe(), Screen::Shows::kBoth).Compose(Grey(0), &small, "", out),
               InputError);
}

TEST(DrawText, IsCutOffAtTheBorder) {
  image::GrayImage image = Grey(0);
  DrawText(image, 295, 100, "longer than the image");
  DrawText(image, -500, 5000, "nowhere");
  long sum = 0;
  for (const std::uint8_t p : image.pixels) sum += p;
  EXPECT_GT(sum, 0);
  for (int r = 0; r < 301; ++r) {
    for (int c = 0; c < 290; ++c) EXPECT_EQ(image.At(c, r), 0);
  }
}

}  // namespace
}  // namespace acus::ultrasound
