#include "acus/patient/phantom/breath/breathing_motion.h"

#include <Eigen/LU>
#include <cstdio>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>

#include "acus/base/core/random.h"
#include "acus/base/math/statistics.h"
#include "support/lung_motion.h"
#include "support/synthetic_trunk.h"

namespace acus::phantom {
namespace {

using breathing::Breath;
using Eigen::Vector3d;

const Cavity& TrunkCavity() {
  static const Cavity cavity = FindCavity(testing_support::SyntheticTrunk(), {});
  return cavity;
}

Vector3d AnyPoint(RandomStream& random) {
  return {random.Uniform(-130, 130), random.Uniform(-95, 95), random.Uniform(-130, 130)};
}

std::vector<Breath> Breaths() {
  return {{.cycle = 0.0, .level = 1.0, .level_per_s = 0.0},
          {.cycle = 0.25, .level = 0.5, .level_per_s = -0.78},
          {.cycle = 0.75, .level = 0.5, .level_per_s = 0.78},
          {.cycle = 0.0, .level = 1.5, .level_per_s = 0.0},
          {.cycle = 0.5, .level = -0.2, .level_per_s = 0.0}};
}

Eigen::Matrix3d Gradient(const BreathingMotion& motion, const Vector3d& p, const Breath& breath) {
  const bool in = motion.InCavity(p);
  Eigen::Matrix3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d h = 0.05 * Vector3d::Unit(axis);
    gradient.col(axis) =
        (motion.WorldMm(p + h, breath, in) - motion.WorldMm(p - h, breath, in)) / 0.1;
  }
  return gradient;
}

TEST(BreathingMotion, FindsTheCavityOfATrunk) {
  const Cavity& cavity = TrunkCavity();
  EXPECT_NEAR(cavity.dome_z_mm, 0.0, 8.0);
  EXPECT_NEAR(cavity.top_z_mm, 120.0, 6.0);
  EXPECT_NEAR(cavity.middle_x_mm, 0.0, 3.0);
  EXPECT_NEAR(cavity.spine_front_mm, 58.0, 6.0);
  EXPECT_NEAR(cavity.skin_front_mm, -106.0, 6.0);
  // The wall is where ribs and lungs are, and bone is outside.
  for (const double z : {-80.0, -20.0, 40.0}) {
    EXPECT_LT(cavity.wall.LevelMm({110.0, 0.0, z}), 0.0);
    EXPECT_GT(cavity.wall.LevelMm({126.0, 0.0, z}), 0.0);
    EXPECT_GT(cavity.wall.LevelMm({0.0, 80.0, z}), 0.0);
    EXPECT_LT(cavity.wall.LevelMm({0.0, 0.0, z}), -20.0);
  }
}

TEST(FindCavity, LabelsAreOneWithinTheWallOnly) {
  const volume::LabelMap labels = LabelsOf(TrunkCavity());
  EXPECT_EQ(labels.names.at(1), "cavity");
  const auto at = [&](double x, double y, double z) {
    const Eigen::Array3i v =
        (labels.geometry.index_from_ct() * Vector3d(x, y, z)).array().round().cast<int>();
    return static_cast<int>(labels.At(v[0], v[1], v[2]));
  };
  for (const double z : {-80.0, -20.0, 40.0}) {
    EXPECT_EQ(at(100, 0, z), 1);
    EXPECT_EQ(at(0, 0, z), 1);
    EXPECT_EQ(at(130, 0, z), 0);
    EXPECT_EQ(at(0, 90, z), 0);
  }
}

TEST(BreathingMotion, NothingMovesAtEndExpiration) {
  const BreathingMotion motion(TrunkCavity(), {});
  RandomStream random(1, "rest");
  for (int n = 0; n < 50; ++n) {
    const Vector3d p = AnyPoint(random);
    EXPECT_EQ(motion.WorldMm(p, {.cycle = 0.5, .level = 0.0, .level_per_s = 0.0}), p);
  }
}

TEST(BreathingMotion, TheDiaphragmGoesAsFarAsRequested) {
  for (const double mm : {10.0, 20.0, 50.0}) {
    const BreathingMotion motion(TrunkCavity(),
                                 {.diaphragm_mm = mm, .chest_mm = 0.0, .hysteresis_mm = 0.0});
    double furthest = 0.0;
    for (double x = -110.0; x <= 110.0; x += 5.0) {
      for (double y = -70.0; y <= 70.0; y += 5.0) {
        const Vector3d p(x, y, TrunkCavity().dome_z_mm);
        furthest = std::max(furthest, p.z() - motion.WorldMm(p, {}).z());
      }
    }
    EXPECT_NEAR(furthest, mm, 0.05 * mm);
    // It falls off away from the diaphragm, and neither spine nor the lungs' top moves.
    const auto down = [&](double z) {
      const Vector3d p(60.0, 10.0, z);
      return p.z() - motion.WorldMm(p, {}).z();
    };
    EXPECT_GT(down(0.0), down(60.0));
    EXPECT_GT(down(60.0), down(100.0));
    EXPECT_NEAR(down(119.0), 0.0, 0.5);
    EXPECT_GT(down(-20.0 - mm), down(-130.0));
    EXPECT_EQ(motion.WorldMm({0.0, 85.0, 10.0}, {}), Vector3d(0.0, 85.0, 10.0));
  }
}

TEST(FindCavity, TheDomeIsNotTakenForTheTopOfTheHeart) {
  volume::LabelMap labels = testing_support::SyntheticTrunk();
  const volume::Geometry& g = labels.geometry;
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    const int i = static_cast<int>(n) % g.size[0];
    const int j = static_cast<int>(n) / g.size[0] % g.size[1];
    const int k = static_cast<int>(n) / (g.size[0] * g.size[1]);
    const Vector3d p = g.origin_mm + 4.0 * Vector3d(i, j, k);
    const bool heart = (p - Vector3d(30.0, -20.0, 20.0)).norm() < 60.0;
    if (heart && labels.voxels[n] == volume::LabelOf("lung")) {
      labels.voxels[n] = volume::LabelOf("soft_tissue");
    }
  }
  const Cavity cavity = FindCavity(labels, {});
  EXPECT_NEAR(cavity.dome_z_mm, 0.0, 8.0);
  for (const double x : {-80.0, 30.0, 60.0}) EXPECT_LT(cavity.diaphragm.AtMm(x, 0.0), 20.0) << x;
}

/// Lung of the trunk as it moves from end expiration to end inspiration.
testing_support::MovedLung TrunkLung(const BreathingMotion& motion) {
  const volume::LabelMap labels = testing_support::SyntheticTrunk();
  testing_support::MovedLung lung;
  for (int k = 0; k < labels.geometry.size[2]; ++k) {
    for (int j = 0; j < labels.geometry.size[1]; j += 2) {
      for (int i = 0; i < labels.geometry.size[0]; i += 2) {
        const Vector3d p = labels.geometry.origin_mm + 4.0 * Vector3d(i, j, k);
        if (labels.At(i, j, k) != volume::LabelOf("lung") || !motion.InCavity(p)) continue;
        lung.Add(p, motion.WorldMm(p, {.cycle = 0.0, .level = 1.0, .level_per_s = 0.0}));
      }
    }
  }
  return lung;
}

// Median of ten patients: shared data, breathing/dirlab.
TEST(BreathingMotion, LungMovesLessTheHigherItIsAsInPatients) {
  const auto motion = testing_support::MotionOf(TrunkLung({TrunkCavity(), {}}));
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    EXPECT_NEAR(motion.by_height[tenth], testing_support::kMedianByHeight[tenth], 0.15) << tenth;
  }
  EXPECT_NEAR(motion.ap_share, testing_support::kMedianApShare, 0.1);
  EXPECT_NEAR(motion.lr_share, testing_support::kMedianLrShare, 0.1);
}

TEST(BreathingMotion, OrgansBelowTheDiaphragmKeepTheirVolume) {
  const BreathingMotion motion(TrunkCavity(), {});
  RandomStream random(5, "organs");
  std::vector<double> determinant, change;
  while (determinant.size() < 400) {
    const Vector3d p(random.Uniform(-90, 90), random.Uniform(-70, 50), random.Uniform(-130, -15));
    if (TrunkCavity().wall.LevelMm(p) > -15.0 || p.z() > TrunkCavity().diaphragm.AtMm(p.x(), p.y()))
      continue;
    determinant.push_back(Gradient(motion, p, Breaths()[0]).determinant());
    change.push_back(std::abs(determinant.back() - 1.0));
  }
  std::printf("  determinant %.3f, mean change of volume %.3f\n", math::Mean(determinant),
              math::Mean(change));
  EXPECT_NEAR(math::Mean(determinant), 1.0, 0.02);
  EXPECT_LT(math::Mean(change), 0.04);
  // The wall of the abdomen gives way by as much.
  const Vector3d belly(0.0, -105.0, -110.0);
  EXPECT_LT(motion.WorldMm(belly, Breaths()[0]).y(), belly.y() - 1.0);
}

TEST(BreathingMotion, TissueSlidesAlongTheWallAndNoGapOpens) {
  const BreathingMotion motion(TrunkCavity(), {.diaphragm_mm = 30.0});
  const SmoothLevel& wall = TrunkCavity().wall;
  double largest_slip_mm = 0.0;
  RandomStream random(2, "wall");
  int tried = 0;
  while (tried < 60) {
    // A point on the wall, by Newton's method.
    Vector3d p = AnyPoint(random);
    for (int n = 0; n < 30; ++n) {
      const auto sample = wall.At(p);
      p -= sample.level_mm / std::max(sample.gradient.squaredNorm(), 0.1) * sample.gradient;
    }
    if (std::abs(wall.LevelMm(p)) > 1e-7 || std::abs(p.z()) > 110.0) continue;
    ++tried;
    for (const Breath& breath : Breaths()) {
      const Vector3d within = motion.WorldMm(p, breath, true);
      // Without the chest's motion, which is common to both sides, it is on the wall again.
      EXPECT_NEAR(wall.LevelMm(motion.BeforeChestMm(within, breath)), 0.0, 0.01);
      largest_slip_mm =
          std::max(largest_slip_mm, (within - motion.WorldMm(p, breath, false)).norm());
    }
  }
  EXPECT_GT(largest_slip_mm, 15.0);
}

TEST(BreathingMotion, IsInvertibleWithoutFoldsOnBothSides) {
  const BreathingMotion motion(TrunkCavity(),
                               {.diaphragm_mm = 50.0, .chest_mm = 10.0, .hysteresis_mm = 5.0});
  RandomStream random(3, "inverse");
  for (int n = 0; n < 200; ++n) {
    const Vector3d p = AnyPoint(random);
    for (const Breath& breath : Breaths()) {
      EXPECT_GT(Gradient(motion, p, breath).determinant(), 0.05) << p.transpose();
      const Vector3d back = motion.RestMm(motion.WorldMm(p, breath), breath);
      if (std::abs(TrunkCavity().wall.LevelMm(p)) > 0.05) {
        EXPECT_LT((back - p).norm(), 0.01) << p.transpose();
      }
    }
  }
}

TEST(BreathingMotion, InsertionIsNotWithdrawal) {
  const BreathingMotion motion(TrunkCavity(), {.hysteresis_mm = 3.0});
  const Vector3d p(60.0, 0.0, -20.0);
  const double rate = std::numbers::pi / motion.settings().period_s;
  const Vector3d in = motion.WorldMm(p, {.cycle = 0.75, .level = 0.5, .level_per_s = rate});
  const Vector3d out = motion.WorldMm(p, {.cycle = 0.25, .level = 0.5, .level_per_s = -rate});
  EXPECT_NEAR((in - out).norm(), 6.0, 0.6);
  const BreathingMotion none(TrunkCavity(), {.hysteresis_mm = 0.0});
  EXPECT_EQ(none.WorldMm(p, {.cycle = 0.75, .level = 0.5, .level_per_s = rate}),
            none.WorldMm(p, {.cycle = 0.25, .level = 0.5, .level_per_s = -rate}));
}

TEST(BreathingMotion, RefusesImpossibleBreathing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double mm : {-1.0, 81.0, nan}) {
    EXPECT_THROW(BreathingMotion(TrunkCavity(), {.diaphragm_mm = mm}), InputError);
  }
  for (const double mm : {-1.0, 31.0, nan}) {
    EXPECT_THROW(BreathingMotion(TrunkCavity(), {.chest_mm = mm}), InputError);
  }
  for (const double mm : {-1.0, 21.0, nan}) {
    EXPECT_THROW(BreathingMotion(TrunkCavity(), {.hysteresis_mm = mm}), InputError);
  }
  for (const double s : {0.4, 61.0, nan}) {
    EXPECT_THROW(BreathingMotion(TrunkCavity(), {.period_s = s}), InputError);
  }
}

TEST(FindCavity, NeedsSpineAndLung) {
  volume::LabelMap labels = testing_support::SyntheticTrunk();
  const auto replaced = [&](const char* what) {
    volume::LabelMap out = labels;
    std::ranges::replace(out.voxels, volume::LabelOf(what), volume::LabelOf("soft_tissue"));
    return out;
  };
  EXPECT_THROW(FindCavity(replaced("bone"), {}), InputError);
  EXPECT_THROW(FindCavity(replaced("lung"), {}), InputError);
  EXPECT_NO_THROW(FindCavity(labels, {}));
}

}  // namespace
}  // namespace acus::phantom
