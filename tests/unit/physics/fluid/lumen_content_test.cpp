#include "acus/physics/fluid/lumen_content.h"

#include <gtest/gtest.h>

namespace acus::fluid {
namespace {

TEST(LumenContent, LiquidPushesAirOutFirst) {
  LumenContent lumen{0.1, 0.0, 0.1};
  const Passage first = lumen.Push({.liquid_ml = 0.06});
  EXPECT_EQ(first.liquid_ml, 0.0);
  EXPECT_DOUBLE_EQ(first.air_ml, 0.06);
  const Passage second = lumen.Push({.liquid_ml = 0.06});
  EXPECT_NEAR(second.air_ml, 0.04, 1e-15);
  EXPECT_NEAR(second.liquid_ml, 0.02, 1e-15);
  EXPECT_NEAR(lumen.liquid_ml, 0.1, 1e-15);
  EXPECT_NEAR(lumen.air_ml, 0.0, 1e-15);
}

TEST(LumenContent, AirPushesLiquidOutFirst) {
  LumenContent lumen{0.1, 0.1, 0.0};
  const Passage out = lumen.Push({.gas_volume_ml = 0.15, .air_ml = 0.3});
  EXPECT_NEAR(out.liquid_ml, 0.1, 1e-15);
  EXPECT_NEAR(out.gas_volume_ml, 0.05, 1e-15);
  EXPECT_NEAR(out.air_ml, 0.1, 1e-15);  // Twice atmospheric.
  EXPECT_NEAR(lumen.air_ml, 0.2, 1e-15);
}

}  // namespace
}  // namespace acus::fluid
