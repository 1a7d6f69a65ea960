#include "acus/assess/regression/comparison/image_difference.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::comparison {
namespace {

struct Image {
  int width;
  int height;
  std::vector<std::uint8_t> pixels;
  GrayView View() const { return {width, height, pixels}; }
};

Image Constant(int width, int height, std::uint8_t value) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height, value)};
}

/// Speckle-like noise around a gradient.
Image Textured(int width, int height, std::uint64_t seed) {
  Image image = Constant(width, height, 0);
  RandomStream random(seed, "image");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double value =
        60.0 + 100.0 * static_cast<double>(i % width) / width + 25 * random.Normal();
    image.pixels[i] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
  }
  return image;
}

/// The definition, straight from the paper, in double and without any separation.
double SsimByDefinition(const Image& a, const Image& b) {
  double weights[11][11];
  double total = 0.0;
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 11; ++x) {
      weights[y][x] = std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / (2 * 1.5 * 1.5));
      total += weights[y][x];
    }
  }
  double sum = 0.0;
  int count = 0;
  for (int top = 0; top + 11 <= a.height; ++top) {
    for (int left = 0; left + 11 <= a.width; ++left) {
      double mu_a = 0, mu_b = 0, aa = 0, bb = 0, ab = 0;
      for (int y = 0; y < 11; ++y) {
        for (int x = 0; x < 11; ++x) {
          const double w = weights[y][x] / total;
          const double va = a.pixels[static_cast<std::size_t>((top + y) * a.width + left + x)];
          const double vb = b.pixels[static_cast<std::size_t>((top + y) * b.width + left + x)];
          mu_a += w * va;
          mu_b += w * vb;
          aa += w * va * va;
          bb += w * vb * vb;
          ab += w * va * vb;
        }
      }
      const double c1 = 2.55 * 2.55;
      const double c2 = 7.65 * 7.65;
      sum += (2 * mu_a * mu_b + c1) * (2 * (ab - mu_a * mu_b) + c2) /
             ((mu_a * mu_a + mu_b * mu_b + c1) * (aa - mu_a * mu_a + bb - mu_b * mu_b + c2));
      ++count;
    }
  }
  return sum / count;
}

TEST(Psnr, IsItsClosedForm) {
  EXPECT_EQ(MeanSquaredError(Constant(7, 5, 100).View(), Constant(7, 5, 90).View()), 100.0);
  EXPECT_NEAR(*PsnrDb(100.0), 28.130803608679106, 1e-12);
  EXPECT_NEAR(*PsnrDb(255.0 * 255.0), 0.0, 1e-12);
  EXPECT_FALSE(PsnrDb(0.0).has_value());
  Image one = Constant(10, 10, 50);
  one.pixels[37] = 70;
  EXPECT_EQ(MeanSquaredError(one.View(), Constant(10, 10, 50).View()), 4.0);
}

TEST(Ssim, IsItsClosedFormOnConstantImages) {
  // No variance: only the luminance term is left.
  const double c1 = 2.55 * 2.55;
  for (const auto& [a, b] : {std::pair{100, 150}, {0, 255}, {3, 4}, {200, 0}}) {
    const double expected = (2.0 * a * b + c1) / (1.0 * a * a + 1.0 * b * b + c1);
    const double ssim = Ssim(Constant(40, 30, static_cast<std::uint8_t>(a)).View(),
                             Constant(40, 30, static_cast<std::uint8_t>(b)).View());
    EXPECT_NEAR(ssim, expected, 1e-5) << a << " " << b;
  }
}

TEST(Ssim, AgreesWithTheDefinition) {
  for (const auto& [width, height] : {std::pair{11, 11}, {40, 25}, {64, 11}, {33, 70}}) {
    const Image a = Textured(width, height, 1);
    Image b = Textured(width, height, 2);
    EXPECT_NEAR(Ssim(a.View(), b.View()), SsimByDefinition(a, b), 2e-5);
    for (std::size_t i = 0; i < b.pixels.size(); ++i) {
      b.pixels[i] = static_cast<std::uint8_t>((3 * a.pixels[i] + b.pixels[i]) / 4);
    }
    EXPECT_NEAR(Ssim(a.View(), b.View()), SsimByDefinition(a, b), 2e-5);
  }
}

TEST(Ssim, IsOneForTheSameAndSymmetricAndFallsWithNoise) {
  const Image a = Textured(80, 60, 3);
  EXPECT_EQ(Ssim(a.View(), a.View()), 1.0);
  double last = 1.0;
  for (const int noise : {1, 4, 12, 40}) {
    Image b = a;
    RandomStream random(9, "noise");
    for (auto& pixel : b.pixels) {
      pixel = static_cast<std::uint8_t>(std::clamp(pixel + noise * random.Normal(), 0.0, 255.0));
    }
    const double ssim = Ssim(a.View(), b.View());
    EXPECT_LT(ssim, last) << noise;
    EXPECT_NEAR(ssim, Ssim(b.View(), a.View()), 1e-6);
    last = ssim;
  }
}

TEST(Ssim, TakesImagesSmallerThanItsWindow) {
  EXPECT_EQ(Ssim(Constant(1, 1, 9).View(), Constant(1, 1, 9).View()), 1.0);
  const double c1 = 2.55 * 2.55;
  EXPECT_NEAR(Ssim(Constant(1, 1, 10).View(), Constant(1, 1, 20).View()), (400 + c1) / (500 + c1),
              1e-5);
  EXPECT_LT(Ssim(Textured(5, 40, 1).View(), Textured(5, 40, 2).View()), 0.9);
}

}  // namespace
}  // namespace acus::comparison
