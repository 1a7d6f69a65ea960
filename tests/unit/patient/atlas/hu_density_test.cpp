#include "acus/patient/atlas/hu_density.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::atlas {
namespace {

TEST(HuDensity, OfOneValueIsTheBlurAroundIt) {
  HuDensity density(8, 0.0);
  for (int n = 0; n < 5; ++n) density.Add(60.2);
  density.Normalise();
  EXPECT_EQ(density.Peak(), 60);
  const double peak = 1.0 / (8.0 * std::sqrt(2.0 * 3.14159265));
  EXPECT_NEAR(density.At(60), peak, 0.01 * peak);
  EXPECT_NEAR(density.At(68), peak * std::exp(-0.5), 0.01 * peak);
}

TEST(HuDensity, SumsToOneAndTakesWhatIsBeyondAtItsEnds) {
  HuDensity density(4, 0.5);
  for (int n = 0; n < 5; ++n) {
    density.Add(-3000.0);
    density.Add(9000.0);
  }
  density.Normalise();
  double sum = 0.0;
  for (int hu = -100; hu < 500; ++hu) sum += density.At(hu);
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_EQ(density.At(-3000.0), density.At(-100.0));
  EXPECT_GT(density.At(-100.0), density.At(200.0));
  EXPECT_GT(density.At(499.0), density.At(200.0));
}

}  // namespace
}  // namespace acus::atlas
