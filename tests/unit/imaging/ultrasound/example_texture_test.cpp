// Textures like an example: the same greys, as long and as wide, without seams.
#include "acus/imaging/ultrasound/columns/example_texture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::ultrasound {
namespace {

constexpr double kPixelMm = 0.15;

TextureExample Shipped(const std::string& name) {
  return TextureExample::Read(std::filesystem::path(ACUS_SOURCE_DIR) / "configs/textures" / name,
                              kPixelMm);
}

/// Greys of a plane of the texture, every pixel of an example apart.
struct Plane {
  static constexpr int kSize = 900;
  std::vector<float> grey = std::vector<float>(kSize * kSize);

  explicit Plane(const std::function<float(float, float)>& at_mm) {
    for (int row = 0; row < kSize; ++row) {
      for (int column = 0; column < kSize; ++column) {
        grey[row * kSize + column] =
            at_mm(static_cast<float>(kPixelMm * column), static_cast<float>(kPixelMm * row));
      }
    }
  }
  double Mean() const {
    double sum = 0.0;
    for (const float g : grey) sum += g;
    return sum / static_cast<double>(grey.size());
  }
  double Deviation() const {
    const double mean = Mean();
    double sum = 0.0;
    for (const float g : grey) sum += (g - mean) * (g - mean);
    return std::sqrt(sum / static_cast<double>(grey.size()));
  }
  double Correlation(int columns, int rows) const {
    const double mean = Mean();
    double sum = 0.0;
    int count = 0;
    for (int row = 0; row + rows < kSize; ++row) {
      for (int column = 0; column + columns < kSize; ++column, ++count) {
        sum += (grey[row * kSize + column] - mean) *
               (grey[(row + rows) * kSize + column + columns] - mean);
      }
    }
    return sum / count / (Deviation() * Deviation());
  }
  /// Where it falls to 1/e, mm.
  double LengthMm(bool along) const {
    double before = 1.0;
    for (int lag = 1;; ++lag) {
      const double now = along ? Correlation(lag, 0) : Correlation(0, lag);
      if (now < 1.0 / std::numbers::e) {
        return kPixelMm * (lag - 1 + (before - 1.0 / std::numbers::e) / (before - now));
      }
      before = now;
    }
  }
};

/// Mean and standard deviation at places far apart.
struct Greys {
  double mean = 0.0;
  double deviation = 0.0;
  Greys(const ExampleTexture& texture, float share_across) {
    RandomStream random(2, "places of greys");
    constexpr int kCount = 200'000;
    double squares = 0.0;
    for (int n = 0; n < kCount; ++n) {
      const auto far = [&] { return static_cast<float>(random.Uniform(-500.0, 500.0)); };
      const double grey = texture.GreyAt({far(), far(), far()}, share_across);
      mean += grey / kCount;
      squares += grey * grey / kCount;
    }
    deviation = std::sqrt(squares - mean * mean);
  }
};

TEST(ExampleTexture, HasTheGreysAndLengthsOfTheExampleAlongItsFibres) {
  const TextureExample example = Shipped("muscle_along.png");
  const ExampleTexture texture(example, std::nullopt, 1);
  EXPECT_GT(example.along_mm(), 4.0 * example.across_mm());
  const Plane across_one([&](float x, float y) {
    return texture.GreyAt({x - 40.0F, y - 30.0F, 7.3F}, 0.0F);
  });
  const Plane across_other([&](float x, float y) {
    return texture.GreyAt({x - 40.0F, 7.3F, y - 30.0F}, 0.0F);
  });
  const Greys greys(texture, 0.0F);
  EXPECT_NEAR(greys.mean, example.mean(), 0.01 * example.mean());
  EXPECT_NEAR(greys.deviation, example.deviation(), 0.02 * example.deviation());
  for (const Plane* plane : {&across_one, &across_other}) {
    EXPECT_NEAR(plane->LengthMm(true), example.along_mm(), 0.12 * example.along_mm());
    EXPECT_NEAR(plane->LengthMm(false), example.across_mm(), 0.12 * example.across_mm());
  }
}

TEST(ExampleTexture, ACutAcrossTheFibresHasDots) {
  const TextureExample along = Shipped("muscle_along.png"), across = Shipped("muscle_across.png");
  const ExampleTexture from_one(along, std::nullopt, 1), from_both(along, across, 1);
  const Plane one([&](float x, float y) { return from_one.GreyAt({3.0F, x, y}, 1.0F); });
  const Plane both([&](float x, float y) { return from_both.GreyAt({3.0F, x, y}, 1.0F); });
  EXPECT_NEAR(one.LengthMm(true), along.across_mm(), 0.12 * along.across_mm());
  EXPECT_NEAR(one.LengthMm(false), along.across_mm(), 0.12 * along.across_mm());
  const Greys greys(from_both, 1.0F);
  EXPECT_NEAR(greys.mean, across.mean(), 0.01 * across.mean());
  EXPECT_NEAR(greys.deviation, across.deviation(), 0.02 * across.deviation());
  EXPECT_NEAR(both.LengthMm(true), across.along_mm(), 0.12 * across.along_mm());
  EXPECT_NEAR(both.LengthMm(false), across.across_mm(), 0.12 * across.across_mm());
}

TEST(ExampleTexture, ObliqueCutsLieBetweenTheTwo) {
  const TextureExample along = Shipped("muscle_along.png"), across = Shipped("muscle_across.png");
  const ExampleTexture texture(along, across, 1);
  double before_mm = 1e9;
  for (const double degrees : {0.0, 30.0, 60.0, 90.0}) {
    const double turned = degrees * std::numbers::pi / 180.0;
    const auto cosine = static_cast<float>(std::cos(turned));
    const auto sine = static_cast<float>(std::sin(turned));
    const Plane plane([&](float x, float y) {
      return texture.GreyAt({cosine * x, sine * x, y}, sine * sine);
    });
    const Greys greys(texture, sine * sine);
    EXPECT_NEAR(greys.deviation, along.deviation(), 0.03 * along.deviation()) << degrees;
    EXPECT_LT(plane.LengthMm(true), before_mm) << degrees;
    before_mm = plane.LengthMm(true);
  }
}

// Contrast, and the steps from pixel to pixel, on the edges of triangles and layers as elsewhere.
TEST(ExampleTexture, ShowsNoSeams) {
  const TextureExample example = Shipped("muscle_along.png");
  const TextureLayers layers(example, example.across_mm(), 5);
  const double edge_mm = 0.4 * (example.length_mm() - kPixelMm);
  const double row_mm = 0.4 * (example.breadth_mm() - kPixelMm);
  const double layer_mm = example.across_mm() / 0.90017;
  RandomStream random(1, "places");
  struct Sums {
    double values = 0.0, squares = 0.0, steps = 0.0;
    int count = 0;
    double largest_step = 0.0;
  } at_seam, elsewhere;
  constexpr double kSeamStepMm = 0.01;
  for (int n = 0; n < 60000; ++n) {
    for (const bool is_seam : {true, false}) {
      // The edges along the fibres are those at whole rows of triangles.
      const double across = row_mm * (std::floor(random.Uniform(-40, 40)) +
                                      (is_seam ? 0.0 : random.Uniform(0.2, 0.8)));
      const double third = layer_mm * (std::floor(random.Uniform(-40, 40)) +
                                       (is_seam ? 0.0 : random.Uniform(0.2, 0.8)));
      const double along = edge_mm * random.Uniform(-40, 40);
      const auto at = [&](double shift) {
        return static_cast<double>(
            layers.GaussianAt({static_cast<float>(along), static_cast<float>(across + shift),
                               static_cast<float>(third + shift)}));
      };
      const double below = at(-0.5 * kSeamStepMm), above = at(0.5 * kSeamStepMm);
      Sums& sums = is_seam ? at_seam : elsewhere;
      sums.values += above;
      sums.squares += above * above;
      sums.steps += (above - below) * (above - below);
      sums.largest_step = std::max(sums.largest_step, std::abs(above - below));
      ++sums.count;
    }
  }
  EXPECT_NEAR(at_seam.values / at_seam.count, 0.0, 0.03);
  EXPECT_NEAR(at_seam.squares / at_seam.count, 1.0, 0.05);
  EXPECT_NEAR(elsewhere.squares / elsewhere.count, 1.0, 0.05);
  EXPECT_LT(at_seam.steps / at_seam.count, 1.5 * elsewhere.steps / elsewhere.count);
  EXPECT_LT(at_seam.largest_step, 2.0 * elsewhere.largest_step);
}

TEST(ExampleTexture, NeverRepeatsAndHasTheSameBitsForTheSameSeed) {
  const TextureExample example = Shipped("fat.png");
  const ExampleTexture one(example, std::nullopt, 1), same(example, std::nullopt, 1),
      other(example, std::nullopt, 2);
  double differs = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const Eigen::Vector3f place(0.37F * static_cast<float>(n) - 150.0F, 2.0F,
                                0.011F * static_cast<float>(n));
    EXPECT_EQ(one.GreyAt(place, 0.0F), same.GreyAt(place, 0.0F));
    differs += std::abs(one.GreyAt(place, 0.0F) - other.GreyAt(place, 0.0F));
  }
  EXPECT_GT(differs / 1000, 0.5 * example.deviation());
}

}  // namespace
}  // namespace acus::ultrasound
