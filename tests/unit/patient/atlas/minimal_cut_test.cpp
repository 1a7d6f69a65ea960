#include "acus/patient/atlas/minimal_cut.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace acus::atlas {
namespace {

volume::Geometry Cube(int size) {
  volume::Geometry g;
  g.size = Eigen::Array3i::Constant(size);
  g.spacing_mm = Eigen::Array3d::Ones();
  return g;
}

/// Preference 1 within a radius [voxels] of the middle, -1 outside.
volume::Grid<float> Ball(int size, double radius) {
  volume::Grid<float> grid(Cube(size), -1.0F);
  const double c = 0.5 * (size - 1);
  for (int k = 0; k < size; ++k) {
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i) {
        if (std::hypot(i - c, j - c, k - c) < radius) grid.At(i, j, k) = 1.0F;
      }
    }
  }
  return grid;
}

int Volume(const volume::Grid<float>& u) {
  return static_cast<int>(std::ranges::count_if(u.voxels, [](float v) { return v > 0.5F; }));
}

TEST(MinimalCut, WithoutCostOfSurfaceIsThePreference) {
  const auto ball = Ball(24, 8.0);
  const auto u = MinimalCut(ball, volume::Grid<float>(ball.geometry, 0.0F), 150, 2);
  for (std::size_t n = 0; n < u.voxels.size(); ++n) {
    EXPECT_EQ(u.voxels[n] > 0.5F, ball.voxels[n] > 0.0F) << n;
  }
}

// A ball of radius r gains p * 4/3 pi r^3 and costs w * 4 pi r^2: it is worth keeping for r > 3
// w/p.
TEST(MinimalCut, ABallVanishesBelowThreeTimesCostOverPreference) {
  const double radius = 6.0;
  const auto ball = Ball(24, radius);
  const auto cheap = volume::Grid<float>(ball.geometry, static_cast<float>(0.8 * radius / 3.0));
  const auto dear = volume::Grid<float>(ball.geometry, static_cast<float>(1.25 * radius / 3.0));
  EXPECT_GT(Volume(MinimalCut(ball, cheap, 2000, 2)), 0.8 * Volume(ball));
  EXPECT_EQ(Volume(MinimalCut(ball, dear, 2000, 2)), 0);
}

TEST(MinimalCut, ANoisyBallBecomesABall) {
  const auto ball = Ball(24, 8.0);
  auto noisy = ball;
  for (std::size_t n = 0; n < noisy.voxels.size(); n += 7) noisy.voxels[n] *= -1.0F;
  const auto u = MinimalCut(noisy, volume::Grid<float>(ball.geometry, 0.7F), 500, 2);
  int wrong = 0;
  for (std::size_t n = 0; n < u.voxels.size(); ++n) {
    wrong += (u.voxels[n] > 0.5F) != (ball.voxels[n] > 0.0F);
  }
  EXPECT_LT(wrong, 0.05 * Volume(ball));
}

// The sides of the grid cost nothing: a slab of 4 voxels pays 0.8 for one face and gains 1.2. All
// axes are alike.
TEST(MinimalCut, ASlabAtAnySideIsTheSameSlab) {
  const int size = 12;
  volume::Grid<float> first(Cube(size));
  for (const int axis : {0, 1, 2}) {
    volume::Grid<float> preference(Cube(size));
    // From one axis to the next, places turn with it.
    const auto turned = [&](int i, int j, int k) {
      const int at[3] = {i, j, k};
      return Eigen::Array3i(at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]);
    };
    for (int n = 0; n < size * size * size; ++n) {
      const int i = n % size, j = n / size % size, k = n / (size * size);
      const Eigen::Array3i at = turned(i, j, k);
      preference.At(i, j, k) = (at[0] >= 8 ? 0.3F : -0.3F) + 0.02F * static_cast<float>(at[1] % 5) -
                               0.03F * static_cast<float>(at[2] % 3);
    }
    const auto u = MinimalCut(preference, volume::Grid<float>(Cube(size), 0.8F), 400, 1);
    for (int n = 0; n < size * size * size; ++n) {
      const int i = n % size, j = n / size % size, k = n / (size * size);
      const Eigen::Array3i at = turned(i, j, k);
      if (axis == 0) {
        first.At(i, j, k) = u.At(i, j, k);
        EXPECT_EQ(u.At(i, j, k) > 0.5F, i >= 8) << i << " " << j << " " << k;
      } else {
        EXPECT_NEAR(u.At(i, j, k), first.At(at[0], at[1], at[2]), 1e-3) << axis;
      }
    }
  }
}

TEST(MinimalCut, TheSameBitsForAnyNumberOfThreads) {
  const auto ball = Ball(17, 5.0);
  const auto cost = volume::Grid<float>(ball.geometry, 0.5F);
  EXPECT_EQ(MinimalCut(ball, cost, 50, 1).voxels, MinimalCut(ball, cost, 50, 5).voxels);
}

}  // namespace
}  // namespace acus::atlas
