#include "acus/patient/segmentation/segmenters/enclosed.h"

#include <gtest/gtest.h>

namespace acus::segmentation {
namespace {

/// A box of walls 4 mm thick around a space of 20 mm, in voxels of 1 mm, with a hole in front.
Mask BoxWithHole(int half_hole) {
  volume::Geometry g;
  g.size = {60, 60, 60};
  Mask walls(g);
  for (int k = 18; k < 46; ++k) {
    for (int j = 18; j < 46; ++j) {
      for (int i = 18; i < 46; ++i) {
        const bool is_inside = std::min({i, j, k}) >= 22 && std::max({i, j, k}) < 42;
        const bool is_hole = j < 22 && std::abs(i - 32) < half_hole && std::abs(k - 32) < half_hole;
        walls.At(i, j, k) = !is_inside && !is_hole ? 1 : 0;
      }
    }
  }
  return walls;
}

TEST(EnclosedByBone, HoldsDespiteAHoleInTheCortex) {
  const Mask enclosed = Enclosed(BoxWithHole(4), 30.0, 21, 2);
  EXPECT_EQ(enclosed.At(32, 32, 32), 1);
  EXPECT_EQ(enclosed.At(25, 38, 28), 1);
  EXPECT_EQ(enclosed.At(32, 8, 32), 0);
  EXPECT_EQ(enclosed.At(50, 32, 32), 0);
}

TEST(EnclosedByBone, DoesNotHoldInAnOpenBoxOrBetweenFarWalls) {
  EXPECT_EQ(Enclosed(BoxWithHole(14), 30.0, 21, 1).At(32, 30, 32), 0);
  EXPECT_EQ(Enclosed(BoxWithHole(0), 8.0, 21, 1).At(32, 32, 32), 0);
}

TEST(EnclosedByBone, IsTheSameOnAnyNumberOfThreads) {
  EXPECT_EQ(Enclosed(BoxWithHole(4), 30.0, 21, 1).voxels,
            Enclosed(BoxWithHole(4), 30.0, 21, 3).voxels);
}

}  // namespace
}  // namespace acus::segmentation
