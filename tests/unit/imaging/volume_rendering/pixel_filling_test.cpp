#include "acus/imaging/volume_rendering/pixel_filling.h"

#include <gmock/gmock.h>

#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using testing_support::PsnrDb;

constexpr float kTolerance = 0.02F;

/// An image whose pixels are known, filled from coarse to fine; where a ray is wanted, the truth.
template <class Truth>
struct FilledTile {
  FilledTile(const TilePlace& place, const Truth& truth,
             std::span<const std::span<const Fragment>> fragments_of = {})
      : pixels(static_cast<std::size_t>(place.width_px * place.height_px)) {
    std::vector<std::uint8_t> wanted;
    FirstPixels(place, wanted);
    const auto cast = [&] {
      for (std::size_t n = 0; n < pixels.size(); ++n) {
        if (wanted[n] == 0) continue;
        const auto column = static_cast<int>(n) % place.width_px;
        pixels[n] = truth(column, static_cast<int>(n) / place.width_px);
        ++num_rays;
        is_cast.push_back(n);
      }
    };
    cast();
    for (int stride = kFirstStride; stride > 1; stride /= 2) {
      FillBetween(place, stride, kTolerance, fragments_of, pixels, wanted);
      cast();
    }
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      const RayColour expected =
          truth(static_cast<int>(n) % place.width_px, static_cast<int>(n) / place.width_px);
      worst = std::max({worst, (pixels[n].colour - expected.colour).abs().maxCoeff(),
                        std::abs(pixels[n].opacity - expected.opacity)});
    }
  }

  std::vector<RayColour> pixels;
  std::vector<std::size_t> is_cast;
  int num_rays = 0;
  float worst = 0.0F;
};

RayColour Grey(float value) {
  return {Eigen::Array3f::Constant(value), value};
}

TEST(PixelFilling, ARampNeedsTheFirstGridAloneAndIsExact) {
  const auto ramp = [](int column, int row) {
    return Grey(0.3F + 0.001F * static_cast<float>(column) + 0.002F * static_cast<float>(row));
  };
  for (const auto& [width, height] : {std::pair{16, 8}, {13, 8}, {1, 1}, {2, 5}, {16, 3}}) {
    const TilePlace place{0, 0, width, height};
    const FilledTile filled(place, ramp);
    std::vector<std::uint8_t> first;
    FirstPixels(place, first);
    EXPECT_EQ(filled.num_rays, std::ranges::count(first, 1)) << width << " " << height;
    EXPECT_LT(filled.worst, 1e-6) << width << " " << height;
  }
}

// What lies between two pixels of the first grid differs from both of them by at most the
// tolerance if it lies between them: so it is on a step, wherever that is.
TEST(PixelFilling, AStepIsCast) {
  for (int edge = 0; edge < 16; ++edge) {
    const auto step = [edge](int column, int row) {
      return Grey(2 * column + row > 2 * edge ? 0.8F : 0.2F);
    };
    const FilledTile filled(TilePlace{0, 0, 16, 8}, step);
    EXPECT_LE(filled.worst, kTolerance) << edge;
    EXPECT_LT(filled.num_rays, 100) << edge;
  }
}

TEST(PixelFilling, NoPixelIsCastTwiceAndAllAreThere) {
  const auto noise = [](int column, int row) {
    return Grey(static_cast<float>((7 * column + 13 * row) % 11) / 11.0F);
  };
  FilledTile filled(TilePlace{0, 0, 15, 7}, noise);
  EXPECT_EQ(filled.num_rays, 15 * 7);
  EXPECT_EQ(filled.worst, 0.0F);
  std::ranges::sort(filled.is_cast);
  EXPECT_TRUE(std::ranges::adjacent_find(filled.is_cast) == filled.is_cast.end());
}

TEST(PixelFilling, APixelWithASurfaceHasItsRay) {
  const Fragment needle{.distance_mm = 10.0F, .opacity = 1.0F};
  std::vector<std::span<const Fragment>> fragments_of(16 * 8);
  const std::size_t pixel = 3 * 16 + 5;  // In no grid but the last.
  fragments_of[pixel] = {&needle, 1};
  const auto with_needle = [&](int column, int row) {
    return Grey(static_cast<std::size_t>(16 * row + column) == pixel ? 1.0F : 0.25F);
  };
  const FilledTile filled(TilePlace{0, 0, 16, 8}, with_needle, fragments_of);
  EXPECT_EQ(filled.worst, 0.0F);
}

TEST(PixelFilling, ImagesOfABodyAreTheSameWithin40Db) {
  const auto ct = testing_support::TrunkCt(128);
  const auto field = testing_support::FieldOf(testing_support::DiaphragmMm);
  const auto motion = testing_support::At(field, 0.8);
  for (const char* layer : {"skin", "bone", "soft_tissue"}) {
    const PatientInView patient{
        .ct = ct, .layers = {{layer, 1.0}}, .surfaces = {}, .field = &field};
    ViewSettings settings;
    PatientView every(patient, settings);
    settings.rays.pixel_tolerance = 0.01;
    PatientView filled(patient, settings);
    const ImageSize size{512, 512};
    const Camera camera = LookAt(ViewFrom("oblique", every.box_in_ct_mm(), size), size);
    ViewImage expected, image, again;
    every.Render(camera, {.motion = &motion}, expected, 2);
    filled.Render(camera, {.motion = &motion}, image, 1);
    EXPECT_GT(PsnrDb(image, expected), 40.0) << layer;
    EXPECT_NE(image.colour.rgb, expected.colour.rgb) << layer;  // Some pixels had no ray.
    filled.Render(camera, {.motion = &motion}, again, 3);
    EXPECT_EQ(again.colour.rgb, image.colour.rgb) << layer;
  }
}

}  // namespace
}  // namespace acus::volume_rendering
