#include "acus/physics/forces/laws/virtual_fixture.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

FixtureSettings Settings() {
  return {.angular_n_mm_per_rad = 1000.0,
          .angular_damping_n_mm_s_per_rad = 2.0,
          .torque_limit_n_mm = 300.0,
          .lateral_n_per_mm = 0.2,
          .lateral_damping_n_s_per_mm = 0.001,
          .force_limit_n = 3.0,
          .redefine_mm = 5.0};
}

Quaterniond RandomRotation(RandomStream& random) {
  return Quaterniond(random.Normal(), random.Normal(), random.Normal(), random.Normal())
      .normalized();
}

// Eq. 7 to 10: back along the rotation that was made, in the needle's axes, the same for q and -q.
TEST(OrientationError, IsTheRotationBackToTheReference) {
  RandomStream random(1, "rotations");
  for (int i = 0; i < 200; ++i) {
    const Quaterniond reference = RandomRotation(random);
    const Vector3d axis = Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    const double angle = random.Uniform(0.0, 3.14);
    const Quaterniond needle = reference * Quaterniond(AngleAxisd(angle, axis));
    const Vector3d error = OrientationErrorRad(reference, needle);
    EXPECT_TRUE(error.isApprox(-angle * axis, 1e-9)) << error.transpose();
    const Quaterniond opposite(-needle.w(), -needle.x(), -needle.y(), -needle.z());
    EXPECT_TRUE(OrientationErrorRad(reference, opposite).isApprox(error, 1e-12));
  }
}

TEST(OrientationError, SurvivesNothingAndTurningRight) {
  const Quaterniond one = Quaterniond::Identity();
  EXPECT_EQ(OrientationErrorRad(one, one).norm(), 0.0);
  const Quaterniond half(AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  EXPECT_NEAR(OrientationErrorRad(one, half).norm(), std::numbers::pi, 1e-12);
  const Quaterniond tiny(AngleAxisd(1e-14, Vector3d::UnitY()));
  EXPECT_NEAR(OrientationErrorRad(one, tiny).y(), -1e-14, 1e-20);
}

TEST(WithoutTwist, PointsAlongTheAxisByTheShortestTurn) {
  RandomStream random(2, "twists");
  for (int i = 0; i < 200; ++i) {
    const Quaterniond reference = RandomRotation(random);
    const Vector3d axis = RandomRotation(random) * Vector3d::UnitZ();
    const Quaterniond needle = WithoutTwist(reference, axis);
    EXPECT_TRUE((needle * Vector3d::UnitZ()).isApprox(axis, 1e-9));
    EXPECT_NEAR(OrientationErrorRad(reference, needle).z(), 0.0, 1e-9);  // No turn about itself.
  }
  const Quaterniond one = Quaterniond::Identity();
  const Quaterniond back = WithoutTwist(one, -Vector3d::UnitZ());
  EXPECT_NEAR((back * Vector3d::UnitZ()).z(), -1.0, 1e-12);
}

TEST(Fixture, TurnsTheNeedleBackAndPushesItToTheLine) {
  Fixture fixture;
  FixtureMotion motion;
  motion.ct_from_needle = AngleAxisd(0.1, Vector3d::UnitX());
  motion.offset_mm = Vector3d(0.0, 4.0, 0.0);
  const FixtureForce out = StepFixture(Settings(), fixture, motion);
  EXPECT_NEAR(out.torque_n_mm.x(), -100.0, 1e-9);  // Eq. 11: k times the angle.
  EXPECT_NEAR(out.torque_n_mm.tail<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(out.force_n.y(), -0.8, 1e-12);
  EXPECT_FALSE(out.trajectory_moved);
}

TEST(Fixture, DampsTurningAndGoingAcrossButNotTwistOrAdvance) {
  Fixture fixture;
  FixtureMotion motion;
  motion.angular_velocity_rad_per_s = Vector3d(3.0, 0.0, 50.0);
  motion.velocity_mm_per_s = Vector3d(0.0, 20.0, 100.0);
  const FixtureForce out = StepFixture(Settings(), fixture, motion);
  EXPECT_TRUE(out.torque_n_mm.isApprox(Vector3d(-6.0, 0.0, 0.0), 1e-12));
  EXPECT_TRUE(out.force_n.isApprox(Vector3d(0.0, -0.02, 0.0), 1e-12));
}

TEST(Fixture, YieldsAtItsLimits) {
  Fixture fixture;
  FixtureMotion motion;
  motion.ct_from_needle = AngleAxisd(1.0, Vector3d::UnitY());
  motion.offset_mm = Vector3d(100.0, 0.0, 0.0);
  FixtureForce out = StepFixture(Settings(), fixture, motion);
  EXPECT_NEAR(out.torque_n_mm.norm(), 300.0, 1e-9);
  EXPECT_NEAR(out.force_n.norm(), 3.0, 1e-12);
  EXPECT_TRUE(out.trajectory_moved);
  EXPECT_NEAR(fixture.angle_rad, 0.3, 1e-12);
  motion.ct_from_needle = AngleAxisd(0.8, Vector3d::UnitY());  // Back by 0.2: from there.
  motion.offset_mm = fixture.offset_mm;
  out = StepFixture(Settings(), fixture, motion);
  EXPECT_NEAR(out.torque_n_mm.norm(), 100.0, 1e-9);
}

// The force of a turned needle fades as it is pushed on: exp(-advance / redefine_mm).
TEST(Fixture, TakesANewTrajectoryWithTheAdvance) {
  Fixture fixture;
  FixtureMotion motion;
  motion.ct_from_needle = AngleAxisd(0.2, Vector3d::UnitX());
  motion.advance_mm = 0.05;
  FixtureForce out;
  for (int i = 0; i < 100; ++i) out = StepFixture(Settings(), fixture, motion);
  EXPECT_NEAR(out.torque_n_mm.norm(), 200.0 * std::exp(-1.0), 1e-6);
  motion.advance_mm = 0.0;
  const FixtureForce still = StepFixture(Settings(), fixture, motion);
  EXPECT_NEAR(still.torque_n_mm.norm(), out.torque_n_mm.norm(), 1e-9);
}

TEST(Fixture, IsBoundedForEveryOrientation) {
  RandomStream random(3, "wild");
  Fixture fixture;
  for (int i = 0; i < 5000; ++i) {
    FixtureMotion motion;
    motion.ct_from_needle =
        WithoutTwist(fixture.ct_from_reference, RandomRotation(random) * Vector3d::UnitZ());
    if (i % 7 == 0)
      motion.ct_from_needle = WithoutTwist(fixture.ct_from_reference, -fixture.DirectionInCt());
    motion.offset_mm = 1e4 * Vector3d(random.Normal(), random.Normal(), random.Normal());
    motion.velocity_mm_per_s = 1e6 * motion.offset_mm;
    motion.angular_velocity_rad_per_s = motion.velocity_mm_per_s;
    motion.advance_mm = random.Uniform(0.0, 50.0);
    const FixtureForce out = StepFixture(Settings(), fixture, motion);
    ASSERT_LE(out.torque_n_mm.norm(), 300.0 * (1 + 1e-12));
    ASSERT_LE(out.force_n.norm(), 3.0 * (1 + 1e-12));
    ASSERT_NEAR(fixture.ct_from_reference.norm(), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace acus::forces
