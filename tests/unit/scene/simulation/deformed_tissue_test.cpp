#include "acus/scene/simulation/deformed_tissue.h"

#include <gtest/gtest.h>

namespace acus::simulation {
namespace {

using Eigen::Vector3d;

/// Soft tissue below z = 0, pressed in by a needle along +z.
class DeformedTissueTest : public testing::Test {
 protected:
  tissue::TissueModel model_{tissue::DisplacementFunctions(
      {}, [](const Vector3d& p) { return p.z() < 0.0 ? 0.0 : 0.05; })};
  tissue::TissueField field_ = model_.NewField();
  DeformedTissue deformed_{model_, 1.0, 60};

  void Press(double depth_mm, double force_n) {
    tissue::TissueLoad load;
    load.needle.in_contact = true;
    load.needle.tip_in_ct_mm = Vector3d(0, 0, depth_mm);
    load.needle.pre_puncture_n = force_n;
    field_.Update(load);
    deformed_.Update(load);
  }
};

TEST_F(DeformedTissueTest, FindsWhereTissueWasHoweverLittleItMoved) {
  for (const double depth_mm : {0.02, 0.3, 4.0}) {
    Press(depth_mm, 0.1 * depth_mm);
    double largest_mm = 0.0;
    for (double z = 6.0; z < 25.0; z += 1.0) {
      const Vector3d now_mm(1.0, 0.0, z);
      const Vector3d rest_mm = deformed_.RestInCtMm(now_mm, now_mm);
      const Vector3d moved_mm = field_.DisplacementMm(rest_mm);
      EXPECT_LE((rest_mm + moved_mm - now_mm).norm(), 0.01) << z;
      largest_mm = std::max(largest_mm, moved_mm.norm());
    }
    EXPECT_GT(largest_mm, 0.5 * depth_mm);
  }
}

TEST_F(DeformedTissueTest, WhatHasNotMovedIsWhereItIs) {
  Press(4.0, 0.4);
  const Vector3d far_mm(50.0, 0.0, 10.0);
  EXPECT_EQ(deformed_.RestInCtMm(far_mm, far_mm + Vector3d(3, 0, 0)), far_mm);
}

}  // namespace
}  // namespace acus::simulation
