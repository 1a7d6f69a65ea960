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

TEST(Screen, TicksAreAtTheirDepth) {
  const Screen screen(AnnotateTestProbe(), Screen::Shows::kBMode);
  image::GrayImage out;
  screen.Compose(Grey(0), nullptr, "", out);
  // 0.2 mm per row: a tick each 25 rows, longer each second one.
  for (int r = 0; r < 301; ++r) {
    EXPECT_EQ(out.At(1, r) > 0, r % 25 == 0) << r;
    EXPECT_EQ(out.At(7, r) > 0, r % 50 == 0) << r;
  }
  EXPECT_GT(out.At(35, 150), 0);  // The focus, at 30 mm.
  EXPECT_EQ(out.At(35, 125), 0);
}

TEST(Screen, PanelsKeepTheirPixelsWhereNothingIsDrawn) {
  const Screen screen(AnnotateTestProbe(), Screen::Shows::kBoth);
  image::GrayImage out;
  const image::GrayImage slice = Grey(90);
  screen.Compose(Grey(40), &slice, "", out);
  EXPECT_EQ(out.width, 602);
  EXPECT_EQ(out.height, 301);
  EXPECT_EQ(out.At(150, 200), 40);
  EXPECT_EQ(out.At(451, 200), 90);
  // The marked side is shown by a circle at the right of each panel.
  EXPECT_GT(out.At(301 - 1 - 12 + 5, 12), 100);
  EXPECT_GT(out.At(602 - 1 - 12 + 5, 12), 100);
}

// A slice of the CT has neither focus nor gain.
TEST(Screen, ASliceAloneIsNotMarkedAsUltrasound) {
  image::GrayImage slice;
  image::GrayImage b_mode;
  Screen(AnnotateTestProbe(), Screen::Shows::kCtSlice).Compose(Grey(0), nullptr, "", slice);
  Screen(AnnotateTestProbe(), Screen::Shows::kBMode).Compose(Grey(0), nullptr, "", b_mode);
  EXPECT_EQ(slice.width, 301);
  EXPECT_EQ(slice.At(35, 150), 0);
  EXPECT_GT(b_mode.At(35, 150), 0);
  // Less is written, at the top right and below; the ring is the same.
  const auto letters = [](const image::GrayImage& image, int from_row, int to_row) {
    return std::count_if(image.pixels.begin() + from_row * 301, image.pixels.begin() + to_row * 301,
                         [](std::uint8_t grey) { return grey > 0; });
  };
  EXPECT_LT(letters(slice, 0, 20), letters(b_mode, 0, 20));
  EXPECT_LT(letters(slice, 285, 301), letters(b_mode, 285, 301));
  EXPECT_EQ(slice.At(301 - 1 - 12 + 5, 12), b_mode.At(301 - 1 - 12 + 5, 12));
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
