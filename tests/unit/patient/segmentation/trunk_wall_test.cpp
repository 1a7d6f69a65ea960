#include "acus/patient/segmentation/segmenters/trunk_wall.h"

#include <gtest/gtest.h>
#include <numbers>

#include "support/synthetic_trunk.h"

namespace acus::segmentation {
namespace {

/// How many voxels of a slice are within the wall.
int InsideOf(const TrunkWall& wall, int k) {
  int count = 0;
  for (int j = 0; j < wall.labels.geometry.size[1]; ++j) {
    for (int i = 0; i < wall.labels.geometry.size[0]; ++i) count += wall.inside.At(i, j, k);
  }
  return count;
}

TEST(TrunkWall, IsWithinTheRibs) {
  const auto wall = FindTrunkWall(testing_support::SyntheticTrunk(), 1);
  ASSERT_TRUE(wall);
  // The inner face is the ellipse x/120, y/85.
  const double ellipse_mm2 = std::numbers::pi * 120.0 * 85.0;
  const int middle = wall->labels.geometry.size[2] / 2;
  EXPECT_NEAR(InsideOf(*wall, middle) * 9.0, ellipse_mm2, 0.15 * ellipse_mm2);
}

// As in a head that bends back: the spine of the slices beside lies in front of the skin of these.
TEST(TrunkWall, SlicesBehindTheSpineHaveNone) {
  volume::LabelMap labels = testing_support::SyntheticTrunk();
  const Eigen::Array3i size = labels.geometry.size;
  for (int k = size[2] - 4; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        labels.At(i, j, k) = j >= size[1] - 6 ? volume::LabelOf("fat") : volume::Label{0};
      }
    }
  }
  const auto wall = FindTrunkWall(labels, 1);
  ASSERT_TRUE(wall);
  EXPECT_EQ(InsideOf(*wall, wall->labels.geometry.size[2] - 1), 0);
  EXPECT_GT(InsideOf(*wall, wall->labels.geometry.size[2] / 2), 0);
}

}  // namespace
}  // namespace acus::segmentation
