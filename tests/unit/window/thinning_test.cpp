#include <gtest/gtest.h>

#include "acus/window/space_layer.h"
#include "support/view_scenes.h"

namespace acus::window {
namespace {

TEST(Thinned, KeepsTheShapeWithFewerTriangles) {
  const mesh::Surface ball = testing_support::BallSurface({10, 20, 30}, 100.0);
  const double volume = mesh::SignedVolumeMm3(ball);
  for (const int most : {500, 2000, 5000}) {
    const mesh::Surface thin = Thinned(ball, most);
    EXPECT_LE(thin.triangles.cols(), most);
    EXPECT_GT(thin.triangles.cols(), most / 2);
    EXPECT_NEAR(mesh::SignedVolumeMm3(thin) / volume, 1.0, 0.02)
        << most << ": not turned inside out";
    for (Eigen::Index n = 0; n < thin.nodes_mm.cols(); ++n) {
      EXPECT_NEAR((thin.nodes_mm.col(n) - Eigen::Vector3d(10, 20, 30)).norm(), 100.0, 2.0);
    }
  }
}

TEST(Thinned, LeavesSmallSurfacesAsTheyAre) {
  const mesh::Surface ball = testing_support::BallSurface({0, 0, 0}, 10.0, 8);
  const mesh::Surface same = Thinned(ball, 10000);
  EXPECT_EQ(same.nodes_mm, ball.nodes_mm);
  EXPECT_EQ(same.triangles, ball.triangles);
}

}  // namespace
}  // namespace acus::window
