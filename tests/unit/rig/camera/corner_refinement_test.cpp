#include "acus/rig/camera/corner_refinement.h"

#include <gtest/gtest.h>

namespace acus::camera {
namespace {

/// A black square on white, its corners at whole pixels' borders.
Image BlackSquare(int low, int high) {
  Image image;
  image.Resize(200, 200, 1);
  for (int row = 0; row < 200; ++row) {
    for (int column = 0; column < 200; ++column) {
      const bool inside = std::min(row, column) >= low && std::max(row, column) < high;
      image.pixels[static_cast<std::size_t>(200 * row + column)] = inside ? 20 : 230;
    }
  }
  return image;
}

TEST(RefineCorners, MovesCornersToTheirEdgesButNotFar) {
  const Image image = BlackSquare(50, 150);
  const auto refined = [&](double off_px) {
    DetectedMarker marker;
    const double low = 49.5 + off_px, high = 149.5 - off_px;
    marker.corners_px = {Eigen::Vector2d(low, low), {high, low}, {high, high}, {low, high}};
    RefineCorners(image, 8, 8.0, nullptr, marker);
    return marker;
  };
  const DetectedMarker close = refined(1.0);
  EXPECT_LT((close.corners_px[0] - Eigen::Vector2d(49.5, 49.5)).norm(), 0.05);
  EXPECT_LT(close.sigma_px[0], 0.2);
  // So far off is another edge: the corner stays where it was found.
  const DetectedMarker distant = refined(4.0);
  EXPECT_EQ(distant.corners_px[0], Eigen::Vector2d(53.5, 53.5));
  EXPECT_EQ(distant.sigma_px[0], 0.7);
}

}  // namespace
}  // namespace acus::camera
