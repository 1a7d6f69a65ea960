#include "acus/patient/phantom/anatomy/liver_ducts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"
#include "support/liver_ducts_checks.h"

namespace acus::phantom {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A ball of liver of 70 mm in soft tissue, in voxels of 1.2 x 1.2 x 2 mm, turned a little, with a
/// vessel through it that is there already.
struct BallOfLiver {
  BallOfLiver() {
    volume::Geometry g;
    g.size = {130, 130, 80};
    g.spacing_mm = {1.2, 1.2, 2.0};
    g.direction = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    ct = volume::CtVolume(g, 40);
    labels = volume::LabelMap(g, volume::LabelOf("soft_tissue"));
    labels.names = {{volume::LabelOf("soft_tissue"), "soft_tissue"},
                    {volume::LabelOf("liver"), "liver"},
                    {volume::LabelOf("vessel"), "vessel"}};
    middle_mm = g.ct_from_index() * Eigen::Vector3d(64.5, 64.5, 39.5);
    RandomStream random(3, "noise of a liver");
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k) - middle_mm;
          if (p.norm() >= 70.0) continue;
          const bool in_vessel = p.head<2>().norm() < 5.0;
          labels.At(i, j, k) = volume::LabelOf(in_vessel ? "vessel" : "liver");
          ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(58.0 + 12.0 * random.Normal()));
        }
      }
    }
  }
  volume::CtVolume ct;
  volume::LabelMap labels;
  Eigen::Vector3d middle_mm;
};

RunContext Seeded(std::uint64_t seed) {
  RunContext context;
  context.seed = seed;
  return context;
}

TEST(LiverDucts, LieInTheLiverAndObeyMurraysLaw) {
  const BallOfLiver ball;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const LiverDuctSettings settings;
    const LiverDucts made = PutDuctsIntoLiver(ball.ct, ball.labels, settings, Seeded(seed));
    EXPECT_GT(made.vessels.size(), 20U);
    EXPECT_GT(made.ducts.size(), 10U);
    testing_support::CheckLiverDucts(ball.ct, ball.labels, settings, made);
  }
}

TEST(LiverDucts, TheSameSeedGivesTheSameBits) {
  const BallOfLiver ball;
  RunContext two_threads = Seeded(5);
  two_threads.num_threads = 2;
  const LiverDucts a = PutDuctsIntoLiver(ball.ct, ball.labels, {}, Seeded(5));
  const LiverDucts b = PutDuctsIntoLiver(ball.ct, ball.labels, {}, two_threads);
  const LiverDucts other = PutDuctsIntoLiver(ball.ct, ball.labels, {}, Seeded(6));
  EXPECT_EQ(a.ct.voxels, b.ct.voxels);
  EXPECT_EQ(a.labels.voxels, b.labels.voxels);
  EXPECT_NE(a.labels.voxels, other.labels.voxels);
}

TEST(LiverDucts, ALesionWhereItIsWanted) {
  const BallOfLiver ball;
  LiverDuctSettings settings;
  settings.lesion_at_mm = ball.middle_mm + Eigen::Vector3d(35, 0, 0);
  settings.lesion_mm = {30, 20, 16};
  const LiverDucts made = PutDuctsIntoLiver(ball.ct, ball.labels, settings, Seeded(1));
  testing_support::CheckLiverDucts(ball.ct, ball.labels, settings, made);
  const auto lesion = volume::LabelOf("lesion");
  const auto count = std::ranges::count(made.labels.voxels, lesion);
  const double ml = 1e-3 * static_cast<double>(count) * ball.ct.geometry.voxel_volume_mm3();
  EXPECT_NEAR(ml, 4.0 / 3.0 * M_PI * 15 * 10 * 8 * 1e-3, 0.15);
  settings.lesion_at_mm = ball.middle_mm;  // In the vessel that is there.
  EXPECT_THAT([&] { PutDuctsIntoLiver(ball.ct, ball.labels, settings, Seeded(1)); },
              ThrowsMessage<InputError>(HasSubstr("inside free liver")));
}

TEST(LiverDucts, WhatHasNoRoomIsSaid) {
  const BallOfLiver ball;
  LiverDuctSettings settings;
  settings.vessel_mm = 50.0;
  settings.margin_mm = 20.0;
  EXPECT_THAT([&] { PutDuctsIntoLiver(ball.ct, ball.labels, settings, Seeded(1)); },
              ThrowsMessage<NoAnswerError>(HasSubstr("the root of the vessels, 50 mm wide")));
  settings.lesion_mm = {100, 100, 100};
  EXPECT_THAT([&] { PutDuctsIntoLiver(ball.ct, ball.labels, settings, Seeded(1)); },
              ThrowsMessage<NoAnswerError>(HasSubstr("a lesion with a radius of 50 mm")));
  volume::LabelMap without = ball.labels;
  std::ranges::replace(without.voxels, volume::LabelOf("liver"), volume::LabelOf("soft_tissue"));
  EXPECT_THAT([&] { PutDuctsIntoLiver(ball.ct, without, {}, Seeded(1)); },
              ThrowsMessage<InputError>(HasSubstr("has no liver")));
}

TEST(DuctTree, AxesApart) {
  const DuctSegment a{.from_mm = {0, 0, 0}, .to_mm = {10, 0, 0}, .radius_mm = 1};
  const auto to = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& end) {
    return AxisDistanceMm(a, {.from_mm = from, .to_mm = end, .radius_mm = 1});
  };
  EXPECT_NEAR(to({5, -5, 3}, {5, 5, 3}), 3.0, 1e-12);   // Across.
  EXPECT_NEAR(to({2, 4, 0}, {8, 4, 0}), 4.0, 1e-12);    // Beside.
  EXPECT_NEAR(to({13, 4, 0}, {20, 4, 0}), 5.0, 1e-12);  // Beyond the end.
  EXPECT_NEAR(to({-3, 0, 4}, {-3, 0, 4}), 5.0, 1e-12);  // A point.
  EXPECT_NEAR(to({4, -6, 0}, {4, -2, 0}), 2.0, 1e-12);  // The end of the other one.
}

}  // namespace
}  // namespace acus::phantom
