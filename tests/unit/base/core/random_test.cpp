#include "acus/base/core/random.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus {
namespace {

TEST(RandomStream, DependsOnSeedNameAndIndexOnly) {
  EXPECT_EQ(RandomStream(1, "tremor", 2).Next(), RandomStream(1, "tremor", 2).Next());
  EXPECT_NE(RandomStream(1, "tremor", 2).Next(), RandomStream(2, "tremor", 2).Next());
  EXPECT_NE(RandomStream(1, "tremor", 2).Next(), RandomStream(1, "noise", 2).Next());
  EXPECT_NE(RandomStream(1, "tremor", 2).Next(), RandomStream(1, "tremor", 3).Next());
}

TEST(RandomStream, HasTheMomentsOfItsDistributions) {
  RandomStream random(7, "moments");
  constexpr int kDraws = 200'000;
  double uniform = 0.0, normal = 0.0, square = 0.0, fourth = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    uniform += random.Uniform();
    const double x = random.Normal();
    normal += x;
    square += x * x;
    fourth += x * x * x * x;
  }
  // Five standard errors each.
  EXPECT_NEAR(uniform / kDraws, 0.5, 5 * std::sqrt(1.0 / 12.0 / kDraws));
  EXPECT_NEAR(normal / kDraws, 0.0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(square / kDraws, 1.0, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3.0, 5 * std::sqrt(96.0 / kDraws));
}

}  // namespace
}  // namespace acus
