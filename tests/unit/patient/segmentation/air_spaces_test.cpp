#include <gtest/gtest.h>

#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/spine/spinal_canal.h"

namespace acus::segmentation {
namespace {

TissueOptions OptionsForAir() {
  return ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json").tissues;
}

/// A block of tissue in voxels of 2 mm with a space of -850 HU, 40 x 40 mm wide, from 20 mm on.
volume::CtVolume WithSpaceTo(int top) {
  volume::Geometry g;
  g.size = {50, 50, 50};
  g.spacing_mm = {2.0, 2.0, 2.0};
  volume::CtVolume ct(g, 40);
  for (int k = 10; k < top; ++k) {
    for (int j = 15; j < 35; ++j) {
      for (int i = 15; i < 35; ++i) ct.At(i, j, k) = -850;
    }
  }
  return ct;
}

TEST(AirSpacesOfABody, AreLungOnlyWhereTheCtCutsThemOrWhole) {
  const Mask body(WithSpaceTo(40).geometry, 1);
  // 96 ml as dense as lung, closed above: gas among stool.
  const AirSpaces closed = FindAirSpaces(WithSpaceTo(40), body, OptionsForAir(), 1);
  EXPECT_EQ(Count(closed.lung), 0U);
  EXPECT_EQ(Count(closed.gas), 20U * 20U * 30U);
  const AirSpaces cut = FindAirSpaces(WithSpaceTo(50), body, OptionsForAir(), 1);
  EXPECT_EQ(Count(cut.lung), 20U * 20U * 40U);
}

TEST(ContrastAgent, IsNotManySmallPartsOfBone) {
  volume::Geometry g;
  g.size = {100, 100, 100};
  volume::CtVolume ct(g, 40);
  // 27 balls of 16 mm, of 300 HU with an edge of 220: cores of 0.5 ml.
  for (int k = 0; k < 90; ++k) {
    for (int j = 0; j < 90; ++j) {
      for (int i = 0; i < 90; ++i) {
        const double r = std::hypot(i % 30 - 15.0, j % 30 - 15.0, k % 30 - 15.0);
        if (r < 8.5) ct.At(i, j, k) = r < 7.5 ? 300 : 220;
      }
    }
  }
  const BoneFound bone = FindDenseBone(ct, Mask(g, 1), OptionsForAir(), 1);
  EXPECT_EQ(Count(bone.contrast), 0U);
  EXPECT_FALSE(bone.enhanced);
}

TEST(CanalChainOfHoles, PrefersTheMiddleOverLongerRowsBesideIt) {
  volume::Geometry g;
  g.size = {100, 100, 100};
  std::vector<CanalHole> holes;
  for (int k = 0; k < 60; ++k) {
    holes.push_back({.k = k, .centre_mm = {90.0, 60.0}, .area_mm2 = 200.0, .from_middle_mm = 45.0});
    if (k >= 30) holes.push_back({.k = k, .centre_mm = {45.0, 60.0}, .area_mm2 = 200.0});
  }
  const auto chain = CanalChain(holes, g);
  ASSERT_EQ(chain.size(), 30U);
  EXPECT_EQ(chain.front().centre_mm.x(), 45.0);
}

/// A row of rings of bone with a body in front, one in the middle and one 70 mm to the left of it.
TEST(CanalHoles, FarBesideTheMiddleOfTheBoneAreNone) {
  volume::Geometry g;
  g.size = {200, 100, 40};
  volume::CtVolume ct(g, 30);
  Mask shell(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        for (const int middle : {80, 150}) {
          const bool is_small = middle == 150;
          const double r = std::hypot(i - middle, j - 60);
          const bool is_body = std::abs(i - middle) < (is_small ? 12 : 20) && j > 25 && j < 50;
          if ((r >= 9.0 && r < 13.0) || (is_body && r >= 13.0)) {
            ct.At(i, j, k) = 300;
            shell.At(i, j, k) = 1;
          }
        }
      }
    }
  }
  const auto holes = FindCanalHoles(ct, shell, 1);
  ASSERT_EQ(holes.size(), 40U);
  for (const CanalHole& hole : holes) EXPECT_NEAR(hole.centre_mm.x(), 80.0, 0.5);
}

}  // namespace
}  // namespace acus::segmentation
