#include "acus/patient/phantom/breath/breathing_motion.h"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>

#include "acus/base/core/random.h"
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
