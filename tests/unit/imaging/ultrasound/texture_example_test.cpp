// What example images may be, and what is read off them.
#include "acus/imaging/ultrasound/columns/texture_example.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::ultrasound {
namespace {

image::GrayImage ExampleOf(int width, int height, const auto& grey_at) {
  image::GrayImage image;
  image.Resize(width, height);
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      image.pixels[static_cast<std::size_t>(r * width + c)] =
          static_cast<std::uint8_t>(grey_at(c, r));
    }
  }
  return image;
}

std::string WhyNot(const image::GrayImage& image, double mm_per_px = 0.1) {
  try {
    TextureExample(image, mm_per_px, "a.png");
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// Columns in blocks of `along` equal pixels, of random greys: correlation 1 - lag / along.
image::GrayImage Blocks(int along) {
  return ExampleOf(512, 64, [along](int c, int r) {
    return RandomStream(1, "blocks", static_cast<std::uint64_t>(1000 * r + c / along)).Next() % 200;
  });
}

TEST(TextureExample, FindsMeanDeviationAndLengths) {
  const TextureExample example(Blocks(8), 0.5, "blocks");
  // Uniform from 0 to 199.
  EXPECT_NEAR(example.mean(), 99.5 / 255, 0.01);
  EXPECT_NEAR(example.deviation(), 200 / std::sqrt(12.0) / 255, 0.01);
  EXPECT_NEAR(example.along_mm(), 0.5 * 8 * (1 - std::exp(-1.0)), 0.15);
  EXPECT_NEAR(example.across_mm(), 0.5 * (1 - std::exp(-1.0)), 0.03);
}

TEST(TextureExample, GreysAreThoseOfTheHistogram) {
  const TextureExample example(Blocks(1), 0.5, "blocks");
  // Quartiles of uniform greys by those of the normal distribution.
  EXPECT_NEAR(example.GreyOf(-0.67449F), 49.5 / 255, 0.01);
  EXPECT_NEAR(example.GreyOf(0.0F), 99.5 / 255, 0.01);
  EXPECT_NEAR(example.GreyOf(0.67449F), 149.5 / 255, 0.01);
  EXPECT_NEAR(example.GreyOf(-100.0F), 0.0, 0.005);
  EXPECT_NEAR(example.GreyOf(100.0F), 199.0 / 255, 0.005);
}

TEST(TextureExample, SaysWhatIsWrongWithAnImage) {
  using testing::HasSubstr;
  EXPECT_THAT(WhyNot(ExampleOf(1, 1, [](int, int) { return 5; })),
              HasSubstr("a.png: is 1 x 1 pixels; an example has at least 32 along and across"));
  EXPECT_THAT(
      WhyNot(ExampleOf(64, 64, [](int, int) { return 77; })),
      HasSubstr("a.png: has hardly more than one grey, 77 of 255; a texture needs several"));
  EXPECT_THAT(WhyNot(Blocks(80)), HasSubstr("an example must be 16 times as large"));
  EXPECT_THAT(WhyNot(ExampleOf(256, 256, [](int c, int) { return c; })),
              HasSubstr("without gradients of depth or gain"));
  EXPECT_THAT(WhyNot(Blocks(2), 0.0), HasSubstr("a pixel of 0 mm; it must be above 0"));
  EXPECT_EQ(WhyNot(Blocks(2)), "");
  EXPECT_THROW(TextureExample::Read("nowhere.png", 0.1), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
