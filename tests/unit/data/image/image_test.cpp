#include "acus/data/image/image.h"

#include <gtest/gtest.h>

namespace acus::image {
namespace {

TEST(ImageGeometry, MapsPixelsToTheProbeAndToTheCt) {
  const ImageGeometry image{.width_px = 101,
                            .height_px = 200,
                            .lateral_mm_per_px = 0.5,
                            .axial_mm_per_px = 0.25,
                            .depth_of_top_row_mm = -2.0};
  const Eigen::Vector3d probe = image.probe_from_image() * Eigen::Vector3d(60, 8, 0);
  EXPECT_NEAR((probe - Eigen::Vector3d(5.0, 0.0, 0.0)).norm(), 0.0, 1e-12);

  const Eigen::Isometry3d ct_from_probe =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d ct = image.ct_from_image(ct_from_probe) * Eigen::Vector3d(60, 8, 0);
  EXPECT_NEAR((ct - Eigen::Vector3d(1, 7, 3)).norm(), 0.0, 1e-12);

  // And back: the map of a flat image can be inverted.
  const Eigen::Vector3d pixel = image.ct_from_image(ct_from_probe).inverse() * ct;
  EXPECT_NEAR((pixel - Eigen::Vector3d(60, 8, 0)).norm(), 0.0, 1e-9);
}

TEST(AlignedFloats, AreAlignedAndGrowOnly) {
  AlignedFloats floats;
  floats.Reserve(100);
  const float* before = floats.data();
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(before) % 64, 0U);
  floats.Reserve(50);
  EXPECT_EQ(floats.data(), before);
  EXPECT_EQ(floats.capacity(), 100U);
  floats.Reserve(101);
  EXPECT_EQ(floats.capacity(), 101U);
}

}  // namespace
}  // namespace acus::image
