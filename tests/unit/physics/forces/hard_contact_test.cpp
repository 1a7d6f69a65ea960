#include "acus/physics/forces/laws/hard_contact.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

/// The paper's constants; A = 19.9 N s/m.
constexpr HardContactSettings kPaper{0.0199, 0.055, 55.0};

// Eq. 12 while the device goes in: then all of the push is against the motion.
TEST(HardContact, IsThePublishedSinusoid) {
  HardContact knock;
  knock.Strike(kPaper, 80.0);
  for (int i = 1; i <= 8; ++i) {  // The first half wave, 9.09 ms.
    const double t = 0.001 * i;
    const double expected_n = 0.0199 * 80.0 * std::exp(std::log(0.01) * t / 0.055) *
                              std::sin(2.0 * std::numbers::pi * 55.0 * t);
    EXPECT_NEAR(knock.Advance(kPaper, 0.05, 0.001, 0.5, 100.0), expected_n, 1e-12) << t;
  }
}

// Without the account it is eq. 12 whichever way the device moves.
TEST(HardContact, AsPrintedItTakesNoHeedOfTheMotion) {
  HardContactSettings printed = kPaper;
  printed.without_account = true;
  HardContact knock;
  HardContact held;
  knock.Strike(printed, 80.0);
  held.Strike(kPaper, 80.0);
  double held_back_n = 0.0;
  for (int i = 1; i <= 54; ++i) {
    const double travel_mm = i % 3 == 0 ? 0.05 : -0.05;
    const double t = 0.001 * i;
    const double expected_n = 0.0199 * 80.0 * std::exp(std::log(0.01) * t / 0.055) *
                              std::sin(2.0 * std::numbers::pi * 55.0 * t);
    EXPECT_NEAR(knock.Advance(printed, travel_mm, 0.001, 0.0, 0.1), expected_n, 1e-12) << t;
    held_back_n = std::max(
        held_back_n, std::abs(held.Advance(kPaper, travel_mm, 0.001, 5.0, 100.0) - expected_n));
  }
  EXPECT_GT(held_back_n, 0.5);
}

TEST(HardContact, EndsAfterItsDuration) {
  HardContact knock;
  knock.Strike(kPaper, 80.0);
  for (int i = 0; i < 54; ++i) knock.Advance(kPaper, 0.01, 0.001, 1.0, 100.0);
  EXPECT_TRUE(knock.running);
  knock.Advance(kPaper, 0.01, 0.0011, 1.0, 100.0);
  EXPECT_FALSE(knock.running);
  EXPECT_EQ(knock.Advance(kPaper, 0.01, 0.001, 1.0, 100.0), 0.0);
}

TEST(HardContact, NeverPullsAndNeverPassesTheLimit) {
  HardContact knock;
  knock.Strike(kPaper, 500.0);
  for (int i = 0; i < 54; ++i) {
    const double spring_n = 1.0;
    const double sum_n =
        spring_n + knock.Advance(kPaper, i < 10 ? 0.1 : -0.01, 0.001, spring_n, 4.0);
    EXPECT_GE(sum_n, 0.0);
    EXPECT_LE(sum_n, 4.0);
  }
}

TEST(HardContact, AWeakerOrSlowerStrikeDoesNotBeginAgain) {
  HardContact knock;
  knock.Strike(kPaper, 80.0);
  knock.Advance(kPaper, 0.05, 0.005, 0.5, 100.0);
  knock.Strike(kPaper, 1.0);
  EXPECT_EQ(knock.impact_mm_per_s, 80.0);
  knock.Strike(kPaper, 79.0);  // After 5 ms 52 mm/s are left.
  EXPECT_EQ(knock.impact_mm_per_s, 79.0);
  EXPECT_EQ(knock.elapsed_s, 0.0);
  HardContact none;
  none.Strike(kPaper, -5.0);
  none.Strike({}, 5.0);
  EXPECT_FALSE(none.running);
}

// A sinusoid in time does not care where the hand goes: without the account it drives one that
// sways with it. With the account the hand never gets back more than it gave.
TEST(HardContact, GivesBackNoMoreThanItTook) {
  double worst_with = 0.0;
  double worst_without = 0.0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed, "knock");
    HardContact knock;
    knock.Strike(kPaper, random.Uniform(5.0, 300.0));
    const double phase = random.Uniform(0.0, 6.283);
    double force_n = 0.0;
    double nominal_n = 0.0;
    double taken = 0.0;
    double taken_without = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double travel_mm = 0.02 * std::sin(2.0 * std::numbers::pi * 55.0 * 0.001 * i + phase) +
                               0.002 * random.Normal();
      taken += force_n * travel_mm;  // The force of the sample before acts over the step.
      taken_without += nominal_n * travel_mm;
      force_n = knock.Advance(kPaper, travel_mm, 0.001, 2.0, 20.0);
      nominal_n = knock.NominalN(kPaper);
      worst_with = std::min(worst_with, taken);
      worst_without = std::min(worst_without, taken_without);
    }
  }
  EXPECT_GT(worst_with, -0.05);
  EXPECT_LT(worst_without, -0.3);
}

}  // namespace
}  // namespace acus::forces
