#include "acus/patient/atlas/organ_place.h"

#include <gtest/gtest.h>

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;

volume::Geometry Box() {
  volume::Geometry g;
  g.size = {50, 44, 60};
  g.spacing_mm = {3.0, 3.0, 3.0};
  return g;
}

Mask EllipsoidAt(const volume::Geometry& g, const Eigen::Array3d& centre,
                 const Eigen::Array3d& half) {
  Mask mask(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        mask.At(i, j, k) = ((Eigen::Array3d(i, j, k) - centre) / half).matrix().norm() <= 1.0;
      }
    }
  }
  return mask;
}

Mask Either(const Mask& a, const Mask& b) {
  Mask out = a;
  for (std::size_t n = 0; n < out.voxels.size(); ++n) out.voxels[n] |= b.voxels[n];
  return out;
}

/// Fat with two kidneys of 32 HU, and a bowel of the same HU that is longer than they are.
class TwoKidneys : public testing::Test {
 protected:
  TwoKidneys() {
    kidneys_ = Either(EllipsoidAt(g_, {12, 20, 30}, kHalf), EllipsoidAt(g_, {36, 24, 34}, kHalf));
    const Mask bowel = EllipsoidAt(g_, {24, 34, 30}, {3, 3, 25});
    for (std::size_t n = 0; n < hu_.voxels.size(); ++n) {
      const bool soft = kidneys_.voxels[n] != 0 || bowel.voxels[n] != 0;
      hu_.voxels[n] = soft ? 32.0F : -100.0F;
    }
  }

  static inline const Eigen::Array3d kHalf{4.2, 5.1, 9.3};
  const volume::Geometry g_ = Box();
  Grid<float> hu_{Box()};
  Mask kidneys_;
};

TEST_F(TwoKidneys, EachIsShiftedToWhereItLies) {
  // The right one by (2, -6, 12), the left one by (-3, 4, -9) voxels.
  const Mask atlas =
      Either(EllipsoidAt(g_, {10, 26, 18}, kHalf), EllipsoidAt(g_, {39, 20, 43}, kHalf));
  EXPECT_EQ(Placed(hu_, atlas, 32.0, 60.0, 1).voxels, kidneys_.voxels);
  EXPECT_EQ(Placed(hu_, atlas, 32.0, 60.0, 3).voxels, kidneys_.voxels);
}

TEST_F(TwoKidneys, StayWhereTheyAreRight) {
  EXPECT_EQ(Placed(hu_, kidneys_, 32.0, 60.0, 1).voxels, kidneys_.voxels);
}

TEST_F(TwoKidneys, AreNotSoughtBeyondTheirReach) {
  const Mask atlas = EllipsoidAt(g_, {12, 20, 18}, kHalf);
  const Mask placed = Placed(hu_, atlas, 32.0, 30.0, 1);
  // 36 mm away, of which 30 are allowed.
  EXPECT_EQ(placed.voxels, EllipsoidAt(g_, {12, 20, 28}, kHalf).voxels);
}

TEST_F(TwoKidneys, StayInATissueThatLooksTheSameEverywhere) {
  const Grid<float> even(g_, 32.0F);
  const Mask atlas = EllipsoidAt(g_, {25, 22, 30}, kHalf);
  EXPECT_EQ(Placed(even, atlas, 32.0, 60.0, 1).voxels, atlas.voxels);
  const Grid<float> air(g_, -1000.0F);
  EXPECT_EQ(Placed(air, atlas, 32.0, 60.0, 1).voxels, atlas.voxels);
}

TEST_F(TwoKidneys, APieceStaysWhereItIs) {
  Mask atlas = kidneys_;
  atlas.At(3, 3, 3) = 1;
  EXPECT_EQ(Placed(hu_, atlas, 32.0, 60.0, 1).voxels, atlas.voxels);
}

/// The body may lie along any axis of the grid.
TEST_F(TwoKidneys, ReachFartherAlongTheBody) {
  Grid<float> hu = hu_;
  Mask atlas = EllipsoidAt(g_, {12, 20, 18}, kHalf);  // 36 mm along k.
  Eigen::Matrix3d turn;                               // z along i: k goes across the body.
  turn << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  for (volume::Geometry* g : {&hu.geometry, &atlas.geometry}) g->direction = turn;
  EXPECT_EQ(Placed(hu, atlas, 32.0, 60.0, 1).voxels, EllipsoidAt(g_, {12, 20, 28}, kHalf).voxels);
}

}  // namespace
}  // namespace acus::atlas
