#include "acus/imaging/volume_rendering/fragments.h"

#include <gtest/gtest.h>
#include <vector>

namespace acus::volume_rendering {
namespace {

/// A square in the x-z plane before the camera; its texture runs from left to right and down.
struct TexturedSquare {
  Eigen::Matrix3Xf nodes{3, 4};
  Eigen::Matrix3Xi triangles{3, 2};
  Eigen::Matrix2Xf texture_at{2, 4};
  image::GrayImage texture;
  Camera camera = LookAt({.eye_in_ct_mm = {0, -500, 0}, .focus_in_ct_mm = {0, 0, 0}}, {64, 64});

  explicit TexturedSquare(bool columns) {
    nodes << -40, 40, 40, -40, 0, 0, 0, 0, -40, -40, 40, 40;
    triangles << 0, 0, 1, 2, 2, 3;
    texture_at << 0, 100, 100, 0, 100, 100, 0, 0;  // The first row of the image is the top.
    texture.Resize(101, 101);
    for (int n = 0; n < 101 * 101; ++n) {
      texture.pixels[static_cast<std::size_t>(n)] =
          static_cast<std::uint8_t>(2 * (columns ? n % 101 : n / 101));
    }
  }

  /// What is met in one pixel.
  std::vector<Fragment> At(int column, int row) const {
    const Drawing drawing{.nodes_mm = &nodes,
                          .triangles = &triangles,
                          .closed = false,
                          .texture = &texture,
                          .texture_at = &texture_at};
    TriangleBands bands;
    bands.Sort(camera, {&drawing, 1}, 1);
    TriangleBands::Band band;
    bands.Draw(row / TriangleBands::kRows, {}, nullptr, band);
    std::vector<Fragment> met;
    const int in_band = row % TriangleBands::kRows * camera.width_px + column;
    TriangleBands::Append(band, static_cast<std::size_t>(in_band), met);
    return met;
  }
};

TEST(Fragments, ATextureLiesWhereItsNodesAre) {
  for (const bool columns : {true, false}) {
    const TexturedSquare square(columns);
    int drawn = 0;
    for (int pixel = 0; pixel < 64 * 64; pixel += 3) {
      const std::vector<Fragment> met = square.At(pixel % 64, pixel / 64);
      if (met.empty()) continue;
      const Eigen::Vector3d ray = square.camera.DirectionInCt({pixel % 64, pixel / 64});
      const Eigen::Vector3d at = 500.0 / ray.y() * ray;
      const double place = 0.5 + (columns ? at.x() : -at.z()) / 80.0;
      EXPECT_NEAR(met.front().colour[0], 200.0 * place / 255.0, 1e-3) << pixel;
      ++drawn;
    }
    EXPECT_GT(drawn, 100);
  }
}

}  // namespace
}  // namespace acus::volume_rendering
