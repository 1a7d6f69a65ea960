#include "acus/patient/breathing_registration/level_image.h"

#include <gmock/gmock.h>

namespace acus::breathing_registration {
namespace {

volume::CtVolume Ramp() {
  volume::Geometry g;
  g.size = {40, 30, 20};
  g.spacing_mm = {1.0, 1.0, 2.0};
  volume::CtVolume ct(g);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 40; ++i) {
        ct.At(i, j, k) = static_cast<std::int16_t>(2 * i - 3 * j + 4 * 2 * k);
      }
    }
  }
  return ct;
}

TEST(ModelImage, AverageOfARampIsTheRamp) {
  const volume::CtVolume ct = Ramp();
  const volume::Geometry grid = CubicGrid(ct.geometry, 3.0);
  EXPECT_EQ(grid.size[0], 14);
  EXPECT_EQ(grid.size[1], 10);
  EXPECT_EQ(grid.size[2], 13);
  const ModelImage image(Averaged(ct, grid, 2), 2);
  // Away from the border: 2, -3, 4 per mm, so 6, -9, 12 per voxel.
  const auto sample = image.At({6.5F, 4.25F, 5.0F});
  EXPECT_TRUE(sample.within);
  EXPECT_NEAR(sample.value, 6 * 6.5 - 9 * 4.25 + 12 * 5.0, 0.5);
  EXPECT_NEAR(sample.gradient.x(), 6.0, 0.1);
  EXPECT_NEAR(sample.gradient.y(), -9.0, 0.1);
  EXPECT_NEAR(sample.gradient.z(), 12.0, 0.3);
}

TEST(ModelImage, KnowsWhatIsBeyondIt) {
  const ModelImage image(Averaged(Ramp(), CubicGrid(Ramp().geometry, 3.0), 1), 1);
  EXPECT_FALSE(image.At({-0.1F, 2.0F, 2.0F}).within);
  EXPECT_FALSE(image.At({2.0F, 9.1F, 2.0F}).within);
  EXPECT_FALSE(image.At({2.0F, std::numeric_limits<float>::quiet_NaN(), 2.0F}).within);
  EXPECT_TRUE(image.At({0.0F, 9.0F, 12.0F}).within);
}

TEST(Contrast, RisesWithHu) {
  for (int hu = -1024; hu < 1500; ++hu) EXPECT_LT(Contrast(hu), Contrast(hu + 1));
  EXPECT_EQ(Contrast(40.0), 40.0);
  EXPECT_EQ(Contrast(-3024.0), Contrast(-1024.0));
}

}  // namespace
}  // namespace acus::breathing_registration
