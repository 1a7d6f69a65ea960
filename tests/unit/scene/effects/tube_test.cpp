#include "acus/scene/effects/tubes/tube.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::effects {
namespace {

constexpr double kRadiusMm = 8.0;
constexpr double kReachMm = 15.0;
constexpr double kStrain = 0.1;

Centreline Straight() {
  return {{{0.0, 0.0, -100.0}, {0.0, 0.0, 100.0}}, {kRadiusMm, kRadiusMm}};
}

Tube StraightTube() {
  return {Straight(), kReachMm, kStrain};
}

double RadiusNow(const Tube& tube, double rest_mm) {
  return tube.WorldMm({rest_mm, 0.0, 0.0}, kStrain).x();
}

TEST(Tube, ItsWallMovesByTheStrain) {
  EXPECT_NEAR(RadiusNow(StraightTube(), kRadiusMm), kRadiusMm * (1.0 + kStrain), 1e-12);
  // Blood in proportion.
  EXPECT_NEAR(RadiusNow(StraightTube(), 0.5 * kRadiusMm), 0.5 * kRadiusMm * (1.0 + kStrain), 1e-12);
}

// The closed form of a ring that keeps its area: r'^2 = r^2 + (R + u)^2 - R^2. With a reach that is
// long the fading changes it little near the wall.
TEST(Tube, IsAnIncompressibleRingWhereTheReachIsLong) {
  const Tube tube(Straight(), 400.0, kStrain);
  const double wall_mm = kRadiusMm * (1.0 + kStrain);
  for (const double rest_mm : {9.0, 12.0, 20.0}) {
    const double ring_mm = std::sqrt(rest_mm * rest_mm + wall_mm * wall_mm - kRadiusMm * kRadiusMm);
    EXPECT_NEAR(RadiusNow(tube, rest_mm), ring_mm, 5e-3) << rest_mm;
  }
}

TEST(Tube, FadesOutSmoothlyAtItsReach) {
  const Tube tube = StraightTube();
  const double reached_mm = kRadiusMm + kReachMm;
  EXPECT_EQ(RadiusNow(tube, reached_mm + 1e-9), reached_mm + 1e-9);
  // To first order, too: a thousandth of the way in moves by a millionth of the way.
  const double inside_mm = reached_mm - 0.02;
  EXPECT_LT(RadiusNow(tube, inside_mm) - inside_mm, 1e-5);
  EXPECT_GT(RadiusNow(tube, inside_mm), inside_mm);
}

TEST(Tube, KeepsTheOrderOfTheTissue) {
  const Tube tube = StraightTube();
  double last_mm = 0.0;
  for (double rest_mm = 0.05; rest_mm < 30.0; rest_mm += 0.05) {
    const double now_mm = RadiusNow(tube, rest_mm);
    EXPECT_GT(now_mm, last_mm) << rest_mm;
    last_mm = now_mm;
  }
}

TEST(Tube, BothDirectionsAreInverse) {
  RandomStream random(7, "vessel");
  const Centreline bent{{{-60, 0, 0}, {-20, 5, 3}, {10, -4, 12}, {50, 0, 30}}, {6, 7, 5, 8}};
  for (const Tube& tube : {StraightTube(), Tube(Resampled(bent, 4.0), 12.0, kStrain)}) {
    double worst_mm = 0.0;
    double most_mm = 0.0;
    for (int n = 0; n < 20000; ++n) {
      const Eigen::Vector3d rest(random.Uniform(-70, 70), random.Uniform(-30, 30),
                                 random.Uniform(-30, 40));
      const double strain = random.Uniform(0.0, kStrain);
      const Eigen::Vector3d now = tube.WorldMm(rest, strain);
      most_mm = std::max(most_mm, (now - rest).norm());
      worst_mm = std::max(worst_mm, (tube.RestMm(now, strain) - rest).norm());
    }
    EXPECT_GT(most_mm, 0.4);
    // Exact about one piece; where another piece is nearer after the motion, by the bend of the
    // line.
    EXPECT_LT(worst_mm, 0.05);
  }
}

TEST(Tube, AStraightOneIsInvertedToTheLastDigits) {
  RandomStream random(8, "tube");
  const Tube tube = StraightTube();
  for (int n = 0; n < 20000; ++n) {
    const Eigen::Vector3d rest(random.Uniform(-30, 30), random.Uniform(-30, 30),
                               random.Uniform(-90, 90));
    const double strain = random.Uniform(0.0, kStrain);
    EXPECT_LT((tube.RestMm(tube.WorldMm(rest, strain), strain) - rest).norm(), 1e-12);
  }
}

TEST(Tube, WhatIsOutOfReachStaysBitByBit) {
  const Tube tube = StraightTube();
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(23.1, 0, 0), Eigen::Vector3d(1, 2, 130), Eigen::Vector3d(0, 0, 3)}) {
    EXPECT_EQ(tube.RestMm(place, kStrain), place);
  }
  EXPECT_EQ(tube.RestMm({9, 1, 2}, 0.0), Eigen::Vector3d(9, 1, 2));
}

TEST(Tube, HardPlacesStayFinite) {
  const Tube doubled({{{0, 0, 0}, {0, 0, 0}, {0, 0, 10}}, {3, 3, 3}}, 10.0, kStrain);
  EXPECT_TRUE(doubled.RestMm({1, 0, -1}, kStrain).allFinite());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(doubled.RestMm({nan, 0, 0}, kStrain).x()));  // Nothing is made up.
  EXPECT_TRUE(doubled.RestMm({0, 0, 1e300}, kStrain).allFinite());
}

TEST(Tube, RefusesWhatWouldFold) {
  EXPECT_THAT([] { Tube(Straight(), 1.0, 0.3); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("would fold")));
  EXPECT_THROW(Tube({{{0, 0, 0}}, {1}}, 10.0, 0.1), InputError);
  EXPECT_THROW(Tube({{{0, 0, 0}, {0, 0, 1}}, {1, 0}}, 10.0, 0.1), InputError);
}

TEST(Centreline, IsResampledEvenlyWithItsEnds) {
  const Centreline line = Resampled({{{0, 0, 0}, {0, 0, 1}, {0, 0, 10}}, {1, 1, 10}}, 3.0);
  ASSERT_EQ(line.point_in_ct_mm.size(), 5U);
  EXPECT_EQ(line.point_in_ct_mm.front(), Eigen::Vector3d(0, 0, 0));
  EXPECT_LT((line.point_in_ct_mm.back() - Eigen::Vector3d(0, 0, 10)).norm(), 1e-12);
  EXPECT_NEAR(line.point_in_ct_mm[1].z(), 2.5, 1e-12);
  EXPECT_NEAR(line.radius_mm[1], 2.5, 1e-12);
}

// A wall that moves in by a strain of its own at every place: the wall is where it should be, and
// what comes back is the place at rest.
TEST(Tube, ContractsByTheStrainOfEachPart) {
  const Tube tube(Straight(), kReachMm, 0.0);
  for (const double strain : {-0.1, -0.5, -0.9}) {
    EXPECT_NEAR(tube.WorldMm({kRadiusMm, 0.0, 0.0}, strain).x(), kRadiusMm * (1.0 + strain), 1e-12);
    double last_mm = 0.0;
    for (double rest_mm = 0.05; rest_mm < 30.0; rest_mm += 0.05) {
      const Eigen::Vector3d now_mm = tube.WorldMm({rest_mm, 0.0, 0.0}, strain);
      EXPECT_GT(now_mm.x(), last_mm);
      last_mm = now_mm.x();
      Tube::Nearest near;
      if (!tube.FindNearest(now_mm, near)) continue;
      EXPECT_NEAR(near.along_mm, 100.0, 1e-12);
      EXPECT_NEAR(tube.RestMm(now_mm, near, strain).x(), rest_mm, 1e-10) << strain;
    }
  }
}

}  // namespace
}  // namespace acus::effects
