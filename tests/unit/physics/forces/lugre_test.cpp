#include "acus/physics/forces/laws/lugre.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

/// Table I of Alamilla-2021, without the filter: the law itself.
LuGreParameters TableOne() {
  return {.sigma0_per_mm = 2.592,
          .sigma1_s_per_mm = 0.000879,
          .sigma2_s_per_mm = 2.04e-3,
          .mu_coulomb = 1.763,
          .mu_static = 0.052,
          .beta_s_per_mm = 0.075,
          .speed_filter_s = 0.0};
}

/// A law whose friction falls with speed, as Stribeck's does.
LuGreParameters Falling() {
  LuGreParameters law = TableOne();
  law.mu_coulomb = 0.4;
  law.mu_static = 1.0;
  law.sigma2_s_per_mm = 0.0;
  return law;
}

TEST(LuGre, SmallDisplacementsMeetASpring) {
  LuGreParameters law = Falling();
  law.sigma1_s_per_mm = 0.0;
  LuGre friction;
  double force_n = 0.0;
  for (int i = 0; i < 1000; ++i) force_n = friction.Advance(law, 1e-6, 0.001, 2.0);
  // 1 um at 1 um/ms; g = 1, so that the bristles' own slip is sigma0 x / (2 g) = 0.13 % of it.
  EXPECT_NEAR(force_n, 2.0 * 2.592 * 1e-3, 2.0 * 2.592 * 1e-3 * 0.002);
  for (int i = 0; i < 1000; ++i) force_n = friction.Advance(law, -1e-6, 0.001, 2.0);
  EXPECT_NEAR(force_n, 0.0, 2.0 * 2.592 * 1e-3 * 0.003);
}

TEST(LuGre, BreaksAwayAtTheStaticCoefficientAndFallsToTheOtherWithSpeed) {
  LuGreParameters law = Falling();
  law.sigma1_s_per_mm = 0.0;
  LuGre friction;
  double creeping_n = 0.0;
  for (int i = 0; i < 6000; ++i) {  // 6 mm at 0.01 mm/s.
    const double force_n = friction.Advance(law, 0.001, 0.1, 1.5);
    ASSERT_GE(force_n, creeping_n - 1e-12);
    creeping_n = force_n;
  }
  EXPECT_NEAR(creeping_n, 1.5 * (0.4 + 0.6 * std::exp(-0.075 * 0.01)), 1e-6);
  double sliding_n = 0.0;
  for (int i = 0; i < 100; ++i) sliding_n = friction.Advance(law, 0.2, 0.001, 1.5);
  EXPECT_NEAR(sliding_n, 1.5 * (0.4 + 0.6 * std::exp(-0.075 * 200.0)), 1e-9);
}

// Eq. 4 at rest of z: F = F_n (g(v) + sigma2 v), at every speed and any step.
TEST(LuGre, SteadySlidingIsTheStribeckCurve) {
  for (const LuGreParameters& law : {TableOne(), Falling()}) {
    for (const double speed : {0.01, 0.1, 1.0, 8.333, 50.0, 200.0, 1000.0, -3.0, -1000.0}) {
      for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
        LuGre friction;
        double force_n = 0.0;
        const int steps = static_cast<int>(std::ceil(12.0 / (std::abs(speed) * dt_s))) + 2;
        for (int i = 0; i < steps; ++i) force_n = friction.Advance(law, speed * dt_s, dt_s, 2.0);
        const double expected_n =
            std::copysign(law.Stribeck(speed), speed) + law.sigma2_s_per_mm * speed;
        EXPECT_NEAR(force_n, 2.0 * expected_n, 2e-4 * std::abs(expected_n)) << speed << " " << dt_s;
      }
    }
  }
}

TEST(LuGre, GoesOverFromOneCoefficientToTheOther) {
  const LuGreParameters law = TableOne();
  EXPECT_NEAR(law.Stribeck(0.0), 0.052, 1e-15);
  EXPECT_NEAR(law.Stribeck(1e4), 1.763, 1e-12);
  EXPECT_NEAR(law.Stribeck(-1.0 / 0.075), 1.763 - 1.711 / std::numbers::e, 1e-12);
}

/// Eq. 4 by classical Runge-Kutta with 200 steps for each of the model's.
struct Reference {
  double z_mm = 0.0;
  double Step(const LuGreParameters& law, double speed, double dt_s, double normal_n) {
    const auto rate = [&](double z) {
      return speed - law.sigma0_per_mm * std::abs(speed) / law.Stribeck(speed) * z;
    };
    const double h = dt_s / 200.0;
    double dz = 0.0;
    for (int i = 0; i < 200; ++i) {
      const double a = rate(z_mm);
      const double b = rate(z_mm + 0.5 * h * a);
      const double c = rate(z_mm + 0.5 * h * b);
      const double d = rate(z_mm + h * c);
      z_mm += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
      dz = rate(z_mm);
    }
    return normal_n *
           (law.sigma0_per_mm * z_mm + law.sigma1_s_per_mm * dz + law.sigma2_s_per_mm * speed);
  }
};

// The paper's experiment: periodic motion. The bristles are those of a fine integration; the force
// differs by sigma1 times the change of their speed within a step.
TEST(LuGre, FollowsAFineIntegration) {
  const LuGreParameters law = TableOne();
  LuGre friction;
  Reference reference;
  const double dt_s = 0.001;
  for (int i = 0; i < 4000; ++i) {
    const double speed = 30.0 * std::sin(2.0 * std::numbers::pi * 1.5 * dt_s * i);
    const double force_n = friction.Advance(law, speed * dt_s, dt_s, 1.0);
    const double expected_n = reference.Step(law, speed, dt_s, 1.0);
    ASSERT_NEAR(friction.bristle_mm, reference.z_mm, 1e-9) << i;
    ASSERT_NEAR(force_n, expected_n, 2e-3) << i;
  }
}

TEST(LuGre, HysteresisLoopsTakeEnergyAndClose) {
  LuGreParameters law = Falling();
  LuGre friction;
  double previous_loop = -1.0;
  for (int loop = 0; loop < 8; ++loop) {
    double work_n_mm = 0.0;
    double before_n = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double phase = 2.0 * std::numbers::pi * i / 2000.0;
      const double travel_mm =
          0.3 * (std::sin(phase + 2.0 * std::numbers::pi / 2000.0) - std::sin(phase));
      const double force_n = friction.Advance(law, travel_mm, 0.001, 1.0);
      if (i > 0 || loop > 0) work_n_mm += 0.5 * (before_n + force_n) * travel_mm;
      before_n = force_n;
    }
    EXPECT_GT(work_n_mm, 0.05);
    if (loop > 3) {
      EXPECT_NEAR(work_n_mm, previous_loop, 0.01 * work_n_mm);
    }
    previous_loop = work_n_mm;
  }
}

// Work in is never less than minus what is stored in the bristles, F_n sigma0 z^2 / 2, whatever the
// motion, the step and the normal force; also with the table's sigma1 read as s/mm, a thousand
// times larger, which the bound on sigma1 makes harmless.
TEST(LuGre, IsPassive) {
  for (const double sigma1 : {0.0, 0.000879, 0.879}) {
    for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
      LuGreParameters law = TableOne();
      law.sigma1_s_per_mm = sigma1;
      RandomStream random(7, "lugre");
      LuGre friction;
      double taken_n_mm = 0.0;
      double speed = 0.0;
      double normal_n = 1.0;
      for (int i = 0; i < 20000; ++i) {
        speed += random.Normal() * 10.0 - 0.1 * speed;
        if (random.Uniform() < 0.01) speed = 0.0;
        if (random.Uniform() < 0.01) normal_n = random.Uniform(0.0, 3.0);
        const double travel_mm = speed * dt_s;
        const double force_n = friction.Advance(law, travel_mm, dt_s, normal_n);
        taken_n_mm += force_n * travel_mm;
        const double stored = 0.5 * normal_n * 2.592 * friction.bristle_mm * friction.bristle_mm;
        ASSERT_GE(taken_n_mm, stored - 1e-9) << i;
      }
      EXPECT_GT(taken_n_mm, 1.0);
    }
  }
}

// Explicit Euler needs sigma0 |v| T / g < 2. Here the steps go far beyond, and nothing overshoots.
TEST(LuGre, IsStableAtAnySpeedAndStep) {
  for (const double sigma1 : {0.0, 0.000879}) {
    LuGreParameters law = Falling();
    law.sigma1_s_per_mm = sigma1;
    for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
      for (const double speed : {0.0, 1e-9, 1.0, 200.0, 1e4, 1e6}) {
        LuGre friction;
        double before_n = 0.0;
        for (int i = 0; i < 50; ++i) {
          const double force_n = friction.Advance(law, speed * dt_s, dt_s, 1.0);
          ASSERT_GE(force_n, 0.0);
          const double g = law.Stribeck(speed);
          ASSERT_LE(force_n, g + std::min(4.0 * g, sigma1 * speed) + 1e-12);
          if (sigma1 == 0.0) {
            ASSERT_GE(force_n, before_n - 1e-15);
          }
          before_n = force_n;
        }
      }
    }
  }
}

TEST(LuGre, AtRestTheForceStays) {
  LuGre friction;
  const LuGreParameters law = TableOne();
  for (int i = 0; i < 500; ++i) friction.Advance(law, 0.01, 0.001, 1.0);
  const double held_n = friction.Advance(law, 0.0, 0.001, 1.0);
  for (int i = 0; i < 100000; ++i) ASSERT_EQ(friction.Advance(law, 0.0, 0.001, 1.0), held_n);
}

TEST(LuGre, AFirmerTissueTakesTheForceOver) {
  LuGreParameters law = Falling();
  law.sigma1_s_per_mm = 0.0;
  LuGre friction;
  for (int i = 0; i < 500; ++i) friction.Advance(law, 0.01, 0.001, 1.0);
  const double before_n = friction.Advance(law, 0.0, 0.001, 1.0);
  EXPECT_NEAR(friction.Advance(law, 0.0, 0.001, 2.5), before_n, 1e-12);
}

// An encoder's steps of 0.02 mm at 1 mm/s look like 20 mm/s now and then.
TEST(LuGre, TheFilterKeepsAnEncoderFromLookingFast) {
  LuGreParameters law = TableOne();
  law.speed_filter_s = 0.02;
  law.sigma1_s_per_mm = 0.0;
  LuGreParameters unfiltered = law;
  unfiltered.speed_filter_s = 0.0;
  LuGre exact, stepped, raw;
  double exact_n = 0.0, stepped_n = 0.0, raw_n = 0.0;
  for (int i = 1; i <= 8000; ++i) {
    exact_n = exact.Advance(law, 0.001, 0.001, 1.0);
    stepped_n = stepped.Advance(law, i % 20 == 0 ? 0.02 : 0.0, 0.001, 1.0);
    raw_n = raw.Advance(unfiltered, i % 20 == 0 ? 0.02 : 0.0, 0.001, 1.0);
  }
  // A step of the encoder comes at the crest of the filtered speed, half above the mean, where this
  // friction is larger.
  EXPECT_NEAR(stepped_n, exact_n, 0.06 * exact_n);
  EXPECT_GT(raw_n, 5.0 * exact_n);
}

}  // namespace
}  // namespace acus::forces
