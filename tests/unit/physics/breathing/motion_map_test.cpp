#include "acus/physics/breathing/motion_map.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::breathing {
namespace {

/// A liver that moves 20 mm towards the feet, falling off over some 60 mm: strain up to 0.4.
MotionModel Diaphragm(double largest_mm) {
  volume::Geometry nodes;
  nodes.size = {33, 33, 33};
  nodes.spacing_mm = {8, 8, 8};
  MotionField field(nodes, 1);
  std::vector<float> values;
  for (int k = 0; k < 33; ++k) {
    for (int j = 0; j < 33; ++j) {
      for (int i = 0; i < 33; ++i) {
        const double r = std::hypot(8.0 * i - 128.0, 8.0 * j - 128.0, 8.0 * k - 128.0) / 60.0;
        const double moved = largest_mm * std::exp(-r * r);
        values.insert(values.end(),
                      {0.0F, static_cast<float>(0.3 * moved), static_cast<float>(moved)});
      }
    }
  }
  field.SetComponent(0, values);
  return MotionModel::Sinusoid(std::move(field), 1.0);
}

Breath At(double t) {
  const double angle = 2.0 * std::numbers::pi * t / 4.0;
  return {.level = 0.5 + 0.5 * std::cos(angle)};
}

TEST(MotionMap, OneWarmIterationFollowsNormalBreathingAtAKilohertz) {
  const MotionModel model = Diaphragm(20.0);
  const Eigen::Vector3d world(120, 100, 140);
  Eigen::Vector3d rest = world;
  double worst_mm = 0.0;
  for (int n = 0; n < 8000; ++n) {
    const MotionMap map(model.field(), model.WeightsAt(At(1e-3 * n)));
    const auto found = map.RestOf(world, rest, {.max_iterations = 1, .tolerance_mm = 0.0});
    rest = found.rest_mm;
    worst_mm = std::max(worst_mm, (map.WorldMm(rest) - world).norm());
  }
  EXPECT_LT(worst_mm, 0.05);
  EXPECT_GT(worst_mm, 0.0);
}

TEST(MotionMap, FiveIterationsSufficeForAPixelFromTheAdjacentOne) {
  const MotionModel model = Diaphragm(20.0);
  const MotionMap map(model.field(), model.WeightsAt({.level = 0.0}));
  double worst_mm = 0.0;
  for (double z = 10; z < 250; z += 2.0) {
    Eigen::Vector3d rest(0, z, 90);
    for (double y = 10; y < 250; y += 2.0) {
      const Eigen::Vector3d world(y, z, 140);
      rest = map.RestOf(world, y == 10 ? world : Eigen::Vector3d(rest + Eigen::Vector3d(2, 0, 0)),
                        {.max_iterations = 5, .tolerance_mm = 0.0})
                 .rest_mm;
      worst_mm = std::max(worst_mm, (map.WorldMm(rest) - world).norm());
    }
  }
  EXPECT_LT(worst_mm, 0.1);
}

TEST(MotionMap, StaysBoundedWhereTheFieldFolds) {
  const MotionModel model = Diaphragm(150.0);
  const MotionMap map(model.field(), model.WeightsAt({.level = 0.0}));
  for (double z = 10; z < 250; z += 3.0) {
    const Eigen::Vector3d world(128, 128, z);
    const auto found = map.RestOf(world, world, {.max_iterations = 20});
    EXPECT_TRUE(found.rest_mm.allFinite());
    EXPECT_LE((found.rest_mm - world).norm(), 2.0 * 160.0);
    EXPECT_LE(found.residual_mm, 160.0);
  }
}

TEST(MotionMap, HeldStillItReturnsPlacesBitForBit) {
  const MotionModel model = Diaphragm(20.0);
  const MotionMap map(model.field(), model.WeightsAt({.level = 0.3}, 0.0));
  const Eigen::Vector3d place(0.1, 1.0 / 3.0, 77.7);
  EXPECT_FALSE(map.moves());
  EXPECT_EQ(map.RestOf(place, {}, {}).rest_mm, place);
  EXPECT_EQ(map.WorldMm(place), place);
  EXPECT_EQ(map.GradientAt(place), Eigen::Matrix3d::Identity());
}

TEST(MotionMap, GradientTurnsDirectionsAsTheTissueDoes) {
  const MotionModel model = Diaphragm(20.0);
  const MotionMap map(model.field(), model.WeightsAt({.level = 0.0}));
  const Eigen::Vector3d place(150, 110, 120);
  const Eigen::Vector3d step(1.0, 0.5, -0.7);
  const Eigen::Vector3d moved = map.WorldMm(place + step) - map.WorldMm(place - step);
  EXPECT_LT((map.GradientAt(place) * (2.0 * step) - moved).norm(), 0.02 * moved.norm());
  const Eigen::Matrix3d turn = RotationOf(map.GradientAt(place));
  EXPECT_LT((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(turn.determinant(), 1.0, 1e-12);
  EXPECT_EQ(RotationOf(-Eigen::Matrix3d::Identity()), Eigen::Matrix3d::Identity());
}

}  // namespace
}  // namespace acus::breathing
