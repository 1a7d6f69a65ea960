#include "acus/imaging/ultrasound/display/auto_gain.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::ultrasound {
namespace {

constexpr double kRangeDb = 60.0;

/// Speckle of one mean level with a third of the image in shadow: grey = 255 (1 + dB / range).
image::GrayImage Speckle(double level_db) {
  image::GrayImage image;
  image.width = 100;
  image.height = 90;
  RandomStream random(7, "speckle");
  for (int n = 0; n < image.width * image.height; ++n) {
    const double intensity = -std::log(1.0 - random.Uniform());
    const double db = 10.0 * std::log10(std::max(intensity, 1e-6)) + level_db;
    const double grey = n % 3 == 0 ? 0.0 : 255.0 * (1.0 + db / kRangeDb);
    image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0)));
  }
  return image;
}

TEST(AutoGain, LeadsToTheSameLevelFromAnyGain) {
  for (const double level_db : {-70.0, -55.0, -45.0, -30.0, -15.0, 0.0, 20.0}) {
    double gain_db = 0.0;
    for (int press = 0; press < 3; ++press) {
      gain_db += AutoGainChangeDb(Speckle(level_db + gain_db), kRangeDb);
    }
    // The median of the intensity is ln 2 of its mean: -1.6 dB.
    const double median_grey = 255.0 * (1.0 + (level_db + gain_db - 1.6) / kRangeDb);
    EXPECT_NEAR(median_grey, kTissueGrey, 4.0) << level_db;
    EXPECT_NEAR(AutoGainChangeDb(Speckle(level_db + gain_db), kRangeDb), 0.0, 1.0) << level_db;
  }
}

TEST(AutoGain, GoesUpInTheDarkAndNeverFurtherThanItsBound) {
  image::GrayImage image{.width = 10, .height = 10, .pixels = std::vector<std::uint8_t>(100, 0)};
  EXPECT_EQ(AutoGainChangeDb(image, kRangeDb), kMostGainChangeDb);
  image.pixels[0] = 255;  // A wire in the dark is no tissue.
  EXPECT_EQ(AutoGainChangeDb(image, kRangeDb), kMostGainChangeDb);
  std::ranges::fill(image.pixels, std::uint8_t{255});
  EXPECT_EQ(AutoGainChangeDb(image, kRangeDb), -kMostGainChangeDb);
  EXPECT_EQ(AutoGainChangeDb({}, kRangeDb), kMostGainChangeDb);
}

}  // namespace
}  // namespace acus::ultrasound
