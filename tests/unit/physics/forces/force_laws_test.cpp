#include "acus/physics/forces/laws/force_laws.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

namespace acus::forces {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::Le;

// Alamilla-2021 eq. 2 with its own coefficients.
TEST(PuncturePolynomial, IsThePublishedOneAndInvertsIt) {
  const PuncturePolynomial liver{0.0480, 0.0052, 2.5};
  EXPECT_DOUBLE_EQ(liver.ForceN(10.0), 0.48 + 0.52);
  EXPECT_EQ(liver.ForceN(0.0), 0.0);
  EXPECT_EQ(liver.ForceN(-3.0), 0.0);
  EXPECT_NEAR(liver.ForceN(liver.PunctureDepthMm()), 2.5, 1e-14);
  EXPECT_NEAR((PuncturePolynomial{0.5, 0.0, 2.0}.PunctureDepthMm()), 4.0, 1e-15);
  EXPECT_NEAR((PuncturePolynomial{0.0, 0.5, 2.0}.PunctureDepthMm()), 2.0, 1e-15);
  EXPECT_EQ((PuncturePolynomial{0.1, 0.1, 0.0}.PunctureDepthMm()), 0.0);
  EXPECT_TRUE(std::isinf(PuncturePolynomial{0.0, 0.0, 1.0}.PunctureDepthMm()));
}

TEST(TrackingWall, RisesElasticallyThenFollowsAndNeverPulls) {
  TrackingWall wall;
  EXPECT_NEAR(wall.Advance(0.1, 1.0, 4.0), 0.4, 1e-15);  // Elastic: 4 N/mm.
  EXPECT_NEAR(wall.Advance(5.0, 1.0, 4.0), 1.0, 1e-15);  // The wall follows at 1 N.
  EXPECT_NEAR(wall.wall_mm, 4.75, 1e-15);
  EXPECT_NEAR(wall.Advance(4.9, 1.0, 4.0), 0.6, 1e-12);  // Back: released elastically...
  EXPECT_EQ(wall.Advance(2.0, 1.0, 4.0), 0.0);           // ...and then nothing.
  EXPECT_EQ(wall.Advance(4.75, 1.0, 4.0), 0.0);          // The cut channel is free.
  EXPECT_NEAR(wall.Advance(5.0, 1.0, 4.0), 1.0, 1e-12);
}

TEST(TrackingWall, StandingStillDoesNotDrift) {
  TrackingWall wall;
  const double force_n = wall.Advance(3.3, 0.7, 2.0);
  for (int i = 0; i < 100000; ++i) ASSERT_EQ(wall.Advance(3.3, 0.7, 2.0), force_n);
}

// dz/ds = 1 - z/z0 from rest: z/z0 = 1 - exp(-s/z0), and the mirror image after turning round.
TEST(BristleFriction, FollowsTheClosedFormWhateverTheStep) {
  for (const double step_mm : {1e-6, 1e-3, 0.1, 0.5}) {
    BristleFriction bristle;
    double share = 0.0;
    const int steps = static_cast<int>(std::lround(0.5 / step_mm));
    for (int i = 0; i < steps; ++i) share = bristle.Slide(step_mm, 0.4);
    EXPECT_NEAR(share, 1.0 - std::exp(-0.5 / 0.4), 1e-9) << step_mm;
    const double turned = share;
    for (int i = 0; i < steps; ++i) share = bristle.Slide(-step_mm, 0.4);
    EXPECT_NEAR(share, -1.0 + (turned + 1.0) * std::exp(-0.5 / 0.4), 1e-9) << step_mm;
  }
}

// 0.1 to 10 ms, 0.001 to 1000 mm/s: bounded, and the sliding friction is reached and reversed.
TEST(BristleFriction, IsStableAtEverySpeedAndStep) {
  for (const double dt_s : {0.0001, 0.001, 0.01}) {
    for (const double speed_mm_per_s : {0.001, 0.1, 10.0, 1000.0}) {
      BristleFriction bristle;
      const double step_mm = speed_mm_per_s * dt_s;
      const long steps = std::min(200000L, std::lround(std::ceil(8.0 / step_mm)));
      double before = 0.0;
      for (long i = 0; i < steps; ++i) {
        const double share = bristle.Slide(step_mm, 0.5);
        ASSERT_THAT(share, AllOf(Ge(before), Le(1.0)))
            << dt_s << " s " << speed_mm_per_s << " mm/s";
        before = share;
      }
      const double travelled_mm = step_mm * static_cast<double>(steps);
      EXPECT_NEAR(before, 1.0 - std::exp(-travelled_mm / 0.5), 1e-6);
      EXPECT_LT(bristle.Slide(-50.0, 0.5), -0.999999);
    }
  }
}

TEST(BristleFriction, StandingStillKeepsItsForce) {
  BristleFriction bristle;
  const double share = bristle.Slide(0.2, 0.5);
  for (int i = 0; i < 100000; ++i) ASSERT_EQ(bristle.Slide(0.0, 0.5), share);
}

TEST(BristleFriction, TakesWorkOutOfEveryClosedLoop) {
  for (const double half_mm : {0.01, 0.1, 1.0, 10.0}) {
    BristleFriction bristle;
    const auto loop = [&] {
      double work = 0.0;
      for (int i = 0; i < 4000; ++i) {
        const double step_mm = (i < 1000 || i >= 3000 ? 1.0 : -1.0) * half_mm / 1000.0;
        work += bristle.Slide(step_mm, 0.5) * step_mm;
      }
      return work;
    };
    for (int i = 0; i < 5; ++i) EXPECT_GT(loop(), 0.0) << half_mm;
  }
}

TEST(BoneSpring, PushesOutOnlyAndIsBounded) {
  const BoneSpring bone{10.0, 0.005, 20.0};
  EXPECT_DOUBLE_EQ(bone.ForceN(0.5, 0.0), 5.0);
  EXPECT_DOUBLE_EQ(bone.ForceN(0.5, 20.0), 5.1);
  EXPECT_EQ(bone.ForceN(0.0, 100.0), 0.0);  // Not before contact.
  EXPECT_EQ(bone.ForceN(0.1, -1e6), 0.0);   // Never pulls in.
  EXPECT_EQ(bone.ForceN(50.0, 1e6), 20.0);
}

// A sampled spring held over each step gives energy away, k/2 per squared step; the damping takes
// b/T. 0.01 N s/mm is twice what 10 N/mm needs at 1 kHz without delay, which also pays for the
// step on which contact begins.
TEST(BoneSpring, DoesNotGiveEnergyWhenPressedAndReleased) {
  const BoneSpring bone{10.0, 0.01, 20.0};
  for (const double hertz : {0.3, 2.0, 10.0, 80.0}) {
    const double amplitude_mm = std::min(0.5, 50.0 / (2.0 * std::numbers::pi * hertz));  // 50 mm/s.
    double work_n_mm = 0.0;
    double force_n = 0.0;
    double before_mm = -amplitude_mm;
    for (int i = 1; i <= 20000; ++i) {
      const double x_mm = -amplitude_mm * std::cos(2.0 * std::numbers::pi * hertz * 0.001 * i);
      work_n_mm += force_n * (x_mm - before_mm);
      force_n = bone.ForceN(x_mm, (x_mm - before_mm) / 0.001);
      before_mm = x_mm;
    }
    EXPECT_GE(work_n_mm, -1e-9) << hertz;
  }
}

}  // namespace
}  // namespace acus::forces
