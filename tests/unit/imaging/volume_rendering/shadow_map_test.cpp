#include "acus/imaging/volume_rendering/shadow_map.h"

#include <gtest/gtest.h>

namespace acus::volume_rendering {
namespace {

using Eigen::Vector3f;

const ShadowFrame kFrame = ShadowMap::FrameOf(
    Vector3f::UnitZ(), Eigen::AlignedBox3f(Vector3f(-20, -20, 50), Vector3f(20, 20, 50)));

/// A square plate 50 mm above the ground, the lamp straight above.
ShadowMap Plate() {
  Eigen::Matrix3Xf nodes(3, 4);
  nodes << -20, 20, 20, -20, -20, -20, 20, 20, 50, 50, 50, 50;
  Eigen::Matrix3Xi triangles(3, 2);
  triangles << 0, 0, 1, 2, 2, 3;
  ShadowMap map;
  map.Begin(kFrame);
  map.Add(nodes, triangles);
  return map;
}

TEST(ShadowMap, OnlyWhatIsBehindAToolIsDark) {
  const ShadowMap map = Plate();
  EXPECT_NEAR(map.LitAt({0, 0, 0}), 0.0F, 1e-6F);
  EXPECT_NEAR(map.LitAt({15, -15, 48}), 0.0F, 1e-6F);
  EXPECT_EQ(map.LitAt({0, 0, 60}), 1.0F) << "between the plate and the lamp";
  EXPECT_EQ(map.LitAt({0, 0, 50}), 1.0F) << "not in one's own shadow";
  EXPECT_EQ(map.LitAt({25, 0, 0}), 1.0F);
  EXPECT_EQ(map.LitAt({1e6F, 0, 0}), 1.0F);
}

TEST(ShadowMap, TheSoftEdgesLieAtTheEdgesOfTheTool) {
  const ShadowMap map = Plate();
  // The light that a line across an edge gets: as if the shadow ended at the edge.
  for (const Vector3f& out :
       {Vector3f(1, 0, 0), Vector3f(-1, 0, 0), Vector3f(0, 1, 0), Vector3f(0, -1, 0)}) {
    double lit_mm = 0.0;
    for (int n = 0; n < 1000; ++n) {
      lit_mm += 0.01 * map.LitAt((15.0F + 0.01F * (static_cast<float>(n) + 0.5F)) * out);
    }
    // Within half a cell.
    EXPECT_NEAR(lit_mm, 5.0, 0.5 * kFrame.mm_per_cell + 0.01) << out.transpose();
  }
}

}  // namespace
}  // namespace acus::volume_rendering
