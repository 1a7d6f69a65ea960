#include "acus/imaging/volume_rendering/visible_blocks.h"

#include <gtest/gtest.h>

#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using testing_support::At;
using testing_support::BallCt;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;

TEST(VisibleBlocks, HoldAllOfABallHoweverItMoves) {
  const auto ct = BallCt({12, -8, 15}, 20.0);
  const VolumeLayer skin{"skin", 1.0};
  const TransferFunction transfer{std::span(&skin, 1)};
  const auto field = FieldOf(DiaphragmMm);
  VisibleBlocks blocks(*ct, transfer, &field);
  for (const double amount : {0.0, 1.0, -2.0, 5.0}) {
    const auto motion = At(field, amount);
    blocks.Update(&motion, 1.0);
    int empty = 0;
    for (int n = 0; n < 4000; ++n) {
      const double a = 0.7 * n;
      const double b = 0.013 * n;
      const Eigen::Vector3d rest =
          Eigen::Vector3d(12, -8, 15) +
          (0.5 + 0.25 * (n % 3)) * 20.0 *
              Eigen::Vector3d(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b));
      const Eigen::Vector3f at = blocks.blocks_from_ct() * motion.WorldMm(rest).cast<float>();
      const Eigen::Array3i block = at.array().floor().cast<int>();
      ASSERT_TRUE((block >= 0).all() && (block < blocks.size()).all());
      EXPECT_EQ(blocks.DistanceOf(block), 0) << amount << ": " << rest.transpose();
    }
    for (int k = 0; k < blocks.size()[2]; ++k) {
      for (int j = 0; j < blocks.size()[1]; ++j) {
        for (int i = 0; i < blocks.size()[0]; ++i) empty += blocks.DistanceOf({i, j, k}) > 0;
      }
    }
    EXPECT_GT(empty, 0.5 * blocks.size().prod());  // And little else.
  }
}

TEST(VisibleBlocks, DistanceIsTheLargestCoordinate) {
  const auto ct = BallCt({12, -8, 15}, 4.0);
  const VolumeLayer skin{"skin", 1.0};
  const TransferFunction transfer{std::span(&skin, 1)};
  VisibleBlocks blocks(*ct, transfer, nullptr);
  blocks.Update(nullptr, 1.0);
  const Eigen::Array3i size = blocks.size();
  std::vector<Eigen::Array3i> visible;
  const auto each = [&](auto body) {
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) body(Eigen::Array3i(i, j, k));
      }
    }
  };
  each([&](const Eigen::Array3i& at) {
    if (blocks.DistanceOf(at) == 0) visible.push_back(at);
  });
  ASSERT_FALSE(visible.empty());
  each([&](const Eigen::Array3i& at) {
    int nearest = 1000;
    for (const auto& other : visible) nearest = std::min(nearest, (other - at).abs().maxCoeff());
    EXPECT_EQ(blocks.DistanceOf(at), nearest);
  });
}

TEST(VisibleBlocks, KnowWhenNothingShows) {
  const VolumeLayer bone{"bone", 1.0};
  VisibleBlocks blocks(*BallCt({500, 0, 0}, 5.0), TransferFunction{std::span(&bone, 1)}, nullptr);
  EXPECT_TRUE(blocks.nothing_visible());
}

}  // namespace
}  // namespace acus::volume_rendering
