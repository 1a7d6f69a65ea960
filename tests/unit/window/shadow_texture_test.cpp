#include "acus/window/shadow_texture.h"

#include <array>
#include <gtest/gtest.h>

#include "support/view_scenes.h"

namespace acus::window {
namespace {

const Eigen::Vector3d kLight(0.0, -1.0, 0.0);

/// Light falls on a ball of 100 mm from in front (-y).
class Shadow : public ::testing::Test {
 protected:
  ShadowTexture shadow_{testing_support::BallSurface({0, 0, 0}, 100.0), kLight};
};

TEST_F(Shadow, OfALineOutsideFallsBehindItAlongTheLight) {
  const std::array<Eigen::Vector3d, 2> line{Eigen::Vector3d(-30, -150, 10), {40, -150, 10}};
  shadow_.AddLine(line, 2.0);
  for (const double x : {-28.0, 0.0, 38.0}) {
    EXPECT_TRUE(shadow_.IsShaded({x, -90.0, 10.0})) << x;
    EXPECT_FALSE(shadow_.IsShaded({x, -90.0, 16.0})) << x;
  }
  EXPECT_FALSE(shadow_.IsShaded({-36.0, -90.0, 10.0}));
}

TEST_F(Shadow, OfWhatIsInsideIsNotSeen) {
  const std::array<Eigen::Vector3d, 2> needle{Eigen::Vector3d(0, -150, 0), {0, 0, 60}};
  shadow_.AddLine(needle, 1.0);
  EXPECT_TRUE(shadow_.IsShaded({0.0, -99.0, 10.0})) << "outside: y is -125 here";
  EXPECT_FALSE(shadow_.IsShaded({0.0, -80.0, 50.0})) << "inside: y is -25 here";
}

TEST_F(Shadow, OfASurfaceHasItsShapeAndMovesWithIt) {
  const mesh::Surface tool = testing_support::BallSurface({0, 0, 0}, 20.0);
  Eigen::Isometry3d ct_from_tool = Eigen::Isometry3d::Identity();
  ct_from_tool.translation() = Eigen::Vector3d(30.0, -160.0, -20.0);
  shadow_.AddSurface(tool, ct_from_tool);
  EXPECT_TRUE(shadow_.IsShaded({30.0, -90.0, -20.0}));
  EXPECT_TRUE(shadow_.IsShaded({48.0, -90.0, -20.0}));
  EXPECT_FALSE(shadow_.IsShaded({53.0, -80.0, -20.0}));
  shadow_.Clear();
  EXPECT_FALSE(shadow_.IsShaded({30.0, -90.0, -20.0}));
}

TEST_F(Shadow, TextureIsDarkAndOpaqueWhereNodesAreShaded) {
  const std::array<Eigen::Vector3d, 2> line{Eigen::Vector3d(-60, -150, 0), {60, -150, 0}};
  shadow_.AddLine(line, 4.0);
  const Texture texture = shadow_.Finish(0.4);
  Eigen::Matrix3Xd nodes(3, 2);
  nodes << 0.0, 0.0, -99.0, -90.0, 0.0, 30.0;
  const Eigen::Matrix2Xf at = shadow_.PlacesOf(nodes);
  const auto pixel = [&](int node, int channel) {
    const int column = static_cast<int>(at(0, node) * static_cast<float>(texture.width));
    const int row = static_cast<int>(at(1, node) * static_cast<float>(texture.height));
    return texture.rgba[static_cast<std::size_t>(4 * (row * texture.width + column) + channel)];
  };
  EXPECT_LT(pixel(0, 0), 100);
  EXPECT_GT(pixel(0, 3), 240);
  EXPECT_EQ(pixel(1, 0), 255);
  EXPECT_EQ(pixel(1, 3), 102);
}

TEST_F(Shadow, TextureReachesHalfAPixelBeyondTheSurfaceOnAllSides) {
  const mesh::Surface ball = testing_support::BallSurface({0, 0, 0}, 100.0);
  const Eigen::Matrix2Xf at = shadow_.PlacesOf(ball.nodes_mm);
  const float half_pixel = 0.5F / ShadowTexture::kSize;
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(at.row(axis).minCoeff(), half_pixel, 1e-5F);
    EXPECT_NEAR(at.row(axis).maxCoeff(), 1.0F - half_pixel, 1e-5F);
  }
}

TEST_F(Shadow, IgnoresWhatIsNotFinite) {
  const double nan = std::nan("");
  const std::array<Eigen::Vector3d, 2> line{Eigen::Vector3d(nan, 0, 0), {0, -150, 0}};
  shadow_.AddLine(line, 1.0);
  EXPECT_FALSE(shadow_.IsShaded({0, -99.0, 0}));
}

}  // namespace
}  // namespace acus::window
