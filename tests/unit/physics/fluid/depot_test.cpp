#include "acus/physics/fluid/depot.h"

#include <gtest/gtest.h>
#include <numbers>

namespace acus::fluid {
namespace {

TEST(Depot, IsASphereOfTheFluidOverItsShare) {
  FluidTissue tissue;
  tissue.fluid_share = 0.5;
  const Depot depot = DepotOf(tissue, {.liquid_ml = 0.8, .air_ml = 0.2});
  EXPECT_NEAR(4.0 / 3.0 * std::numbers::pi * std::pow(depot.width_radius_mm, 3), 2000.0, 1e-9);
  EXPECT_EQ(depot.thickness_radius_mm, depot.width_radius_mm);
}

TEST(Depot, LiesFlatBetweenLayers) {
  FluidTissue tissue;
  tissue.flatness = 0.1;
  const Depot depot = DepotOf(tissue, {.liquid_ml = 5.0});
  EXPECT_NEAR(4.0 / 3.0 * std::numbers::pi * depot.width_radius_mm * depot.width_radius_mm *
                  depot.thickness_radius_mm,
              5000.0, 1e-9);
  EXPECT_NEAR(depot.thickness_radius_mm, 0.1 * depot.width_radius_mm, 1e-12);
}

TEST(Depot, IsNoneWhereContentWasDrawn) {
  const Depot depot = DepotOf({}, {.liquid_ml = -3.0});
  EXPECT_EQ(depot.width_radius_mm, 0.0);
  EXPECT_EQ(depot.liquid_ml, 0.0);
}

}  // namespace
}  // namespace acus::fluid
