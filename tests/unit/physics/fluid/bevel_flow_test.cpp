#include "acus/physics/fluid/bevel_flow.h"

#include <gtest/gtest.h>

namespace acus::fluid {
namespace {

TEST(BevelFlow, RisesAboveTheOpeningPressureAndReturnsBelowThatOfTheTissue) {
  BevelLaw law;
  law.branch[0] = {
      .tissue_kpa = 2.0, .opening_kpa = 5.0, .kpa_s_per_ml = 4.0, .least_ml_per_s = -0.5};
  EXPECT_EQ(law.FlowAt(9.0).ml_per_s, 0.5);
  EXPECT_EQ(law.FlowAt(9.0).slope_ml_per_kpa_s, 0.25);
  EXPECT_EQ(law.FlowAt(6.9).ml_per_s, 0.0);
  EXPECT_EQ(law.FlowAt(2.1).ml_per_s, 0.0);
  EXPECT_EQ(law.FlowAt(1.0).ml_per_s, -0.25);
  EXPECT_EQ(law.FlowAt(-9.0).ml_per_s, -0.5);  // All that can return.
  EXPECT_EQ(law.FlowAt(-9.0).slope_ml_per_kpa_s, 0.0);
}

TEST(BevelFlow, TwoTissuesAddUp) {
  BevelLaw law;
  law.branch[0] = {
      .tissue_kpa = 0.0, .opening_kpa = 0.0, .kpa_s_per_ml = 4.0, .least_ml_per_s = -1.0};
  law.branch[1] = {
      .tissue_kpa = 6.0, .opening_kpa = 0.0, .kpa_s_per_ml = 2.0, .least_ml_per_s = -1.0};
  const BevelFlow flow = law.FlowAt(4.0);  // In through one, out of the other.
  EXPECT_EQ(flow.branch_ml_per_s[0], 1.0);
  EXPECT_EQ(flow.branch_ml_per_s[1], -1.0);
  EXPECT_EQ(flow.ml_per_s, 0.0);
}

}  // namespace
}  // namespace acus::fluid
