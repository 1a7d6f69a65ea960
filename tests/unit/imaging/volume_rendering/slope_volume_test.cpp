#include "acus/imaging/volume_rendering/slope_volume.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace acus::volume_rendering {
namespace {

/// HU that rise by `slope` along the axes, of voxels whose edges differ.
volume::CtVolume Ramp(const Eigen::Vector3d& slope_hu_per_mm) {
  volume::Geometry g;
  g.size = {20, 16, 12};
  g.spacing_mm = {0.8, 1.25, 2.5};
  volume::CtVolume ct(g, std::int16_t{0});
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d place_mm = Eigen::Array3d(i, j, k) * g.spacing_mm;
        ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(slope_hu_per_mm.dot(place_mm)));
      }
    }
  }
  return ct;
}

TEST(SlopeVolume, OfARampIsItsSlopeAlongEveryAxis) {
  // Rounded HU over 3 mm and more, and half a unit.
  constexpr double kRounding = 1.0 / 3.0 + 0.5 * SlopeVolume::kUnit;
  for (const Eigen::Vector3d& slope : {Eigen::Vector3d(40, 0, 0), Eigen::Vector3d(0, 60, 0),
                                       Eigen::Vector3d(0, 0, -50), Eigen::Vector3d(30, -45, 60)}) {
    const SlopeVolume slopes(Ramp(slope), 1);
    for (const Eigen::Vector3f& index :
         {Eigen::Vector3f(3, 3, 2), Eigen::Vector3f(9.5F, 8.25F, 6.75F),
          Eigen::Vector3f(15, 13, 9)}) {
      const Eigen::Vector3d off = slopes.At(index).cast<double>() - slope;
      EXPECT_LT(off.cwiseAbs().maxCoeff(), kRounding) << slope.transpose() << " at " << index;
    }
  }
}

TEST(SlopeVolume, SteeperThanCanBeStoredKeepsItsDirection) {
  const Eigen::Vector3d slope(150, -200, 100);
  const SlopeVolume slopes(Ramp(slope), 1);
  const Eigen::Vector3d there = slopes.At({8, 8, 5}).cast<double>();
  EXPECT_NEAR(there.norm(), SlopeVolume::kSteepest, 2.0 * SlopeVolume::kUnit);
  EXPECT_GT(there.normalized().dot(slope.normalized()), 0.9998);
}

TEST(SlopeVolume, BeyondTheBorderIsAir) {
  const SlopeVolume slopes(Ramp(Eigen::Vector3d::Zero()), 1);
  EXPECT_EQ(slopes.At({9, 8, 5}).norm(), 0.0F);
  // Steeper than can be stored: 1024 HU over 3 mm and less.
  EXPECT_NEAR(slopes.At({0, 8, 5}).x(), SlopeVolume::kSteepest, SlopeVolume::kUnit);
  EXPECT_NEAR(slopes.At({19, 8, 5}).x(), -SlopeVolume::kSteepest, SlopeVolume::kUnit);
  EXPECT_NEAR(slopes.At({9, 15, 5}).y(), -SlopeVolume::kSteepest, SlopeVolume::kUnit);
  EXPECT_NEAR(slopes.At({9, 8, 0}).z(), SlopeVolume::kSteepest, SlopeVolume::kUnit);
}

TEST(SlopeVolume, IsTheSameWithAnyThreads) {
  const volume::CtVolume ct = Ramp({30, -45, 60});
  const SlopeVolume one(ct, 1), three(ct, 3);
  EXPECT_TRUE(std::equal(one.units(), one.units() + 4 * ct.geometry.num_voxels(), three.units()));
}

}  // namespace
}  // namespace acus::volume_rendering
