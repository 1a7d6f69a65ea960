#include "acus/imaging/slicing/ct_slice.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "support/synthetic_ct.h"

namespace acus::slicing {
namespace {

const image::ImageGeometry kImage{
    .width_px = 101, .height_px = 83, .lateral_mm_per_px = 0.5, .axial_mm_per_px = 0.5};

/// The probe on the front of the body (LPS: y grows towards the back), marked side to the left.
Eigen::Isometry3d FrontPose() {
  return Eigen::Isometry3d(Eigen::Translation3d(30, 5, 20));
}

/// A block of 900 HU around one place.
volume::CtVolume Marker(const Eigen::Vector3d& at) {
  return testing_support::SyntheticCt({60, 60, 40}, 1.0, [&](double x, double y, double z) {
    return (Eigen::Vector3d(x, y, z) - at).cwiseAbs().maxCoeff() < 2.1 ? 900.0 : 40.0;
  });
}

TEST(CtSlice, TheMarkedSideIsRightAndDepthIsDown) {
  const volume::CtVolume ct = Marker({45, 25, 20});
  CtSliceRenderer renderer(ct, kImage, 2.0);
  image::GrayImage image;
  renderer.Render(FrontPose(), {}, image);
  const Eigen::Vector3d pixel =
      kImage.ct_from_image(FrontPose()).inverse() * Eigen::Vector3d(45, 25, 20);
  EXPECT_NEAR(pixel.x(), 50 + 30, 1e-9);
  EXPECT_NEAR(pixel.y(), 40, 1e-9);
  EXPECT_EQ(image.At(80, 40), 255);
  EXPECT_EQ(image.At(20, 40), 128);  // Mirrored.
  EXPECT_EQ(image.At(80, 30), 128);  // Above.
}

TEST(CtSlice, TurningTheProbeRoundMirrorsTheImage) {
  const volume::CtVolume ct = Marker({45, 25, 20});
  CtSliceRenderer renderer(ct, kImage, 2.0);
  image::GrayImage straight;
  image::GrayImage turned;
  renderer.Render(FrontPose(), {}, straight);
  renderer.Render(FrontPose() * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()), {}, turned);
  for (int r = 0; r < 83; ++r) {
    for (int c = 0; c < 101; ++c) EXPECT_NEAR(straight.At(c, r), turned.At(100 - c, r), 1);
  }
}

TEST(CtSlice, TheWindowGoesFromBlackToWhite) {
  const auto ct = testing_support::SyntheticCt(
      {60, 60, 40}, 1.0, [](double x, double, double) { return 20.0 * (x - 30.0); });
  CtSliceRenderer renderer(ct, kImage, 2.0, {.centre_hu = 40, .width_hu = 400});
  image::GrayImage image;
  renderer.Render(FrontPose(), {}, image);
  for (int c = 0; c < 101; ++c) {
    const double hu = 20.0 * (c - 50) * 0.5;
    const double expected = std::clamp(255.0 * (hu - (40.0 - 200.0)) / 400.0, 0.0, 255.0);
    EXPECT_NEAR(image.At(c, 40), expected, 0.51) << hu << " HU";
    EXPECT_NEAR(renderer.hu().row(40)[c], hu, 1e-3);
  }
}

TEST(CtSlice, ShowsTheNeedleWhite) {
  const volume::CtVolume ct = Marker({5, 5, 5});
  CtSliceRenderer renderer(ct, kImage, 2.0);
  image::NeedleInImage needle;
  needle.tip_in_ct_mm << 30, 25, 20;
  needle.axis_in_ct << 0, 1, 0;
  needle.length_mm = 100;
  needle.radius_mm = 0.6;
  image::GrayImage image;
  renderer.Render(FrontPose(), needle, image);
  EXPECT_EQ(image.At(50, 0), 255);
  EXPECT_EQ(image.At(50, 40), 255);
  EXPECT_EQ(image.At(50, 41), 128);
}

TEST(CtSlice, AnyWidthGivesTheSamePixels) {
  const volume::CtVolume ct = Marker({45, 25, 20});
  image::GrayImage wide;
  CtSliceRenderer(ct, kImage, 2.0).Render(FrontPose(), {}, wide);
  for (const int width : {1, 15, 17, 33, 99}) {
    image::ImageGeometry geometry = kImage;
    geometry.width_px = width;
    image::GrayImage image;
    CtSliceRenderer(ct, geometry, 2.0).Render(FrontPose(), {}, image);
    for (int r = 0; r < 83; ++r) {
      for (int c = 0; c < width; ++c) {
        EXPECT_EQ(image.At(c, r), wide.At(c + (101 - width) / 2, r)) << width;
      }
    }
  }
}

TEST(CtSlice, RefusesAWindowWithoutWidth) {
  const volume::CtVolume ct = Marker({45, 25, 20});
  EXPECT_THROW(CtSliceRenderer(ct, kImage, 2.0, {.centre_hu = 0, .width_hu = 0}), InputError);
  EXPECT_THROW(CtSliceRenderer(ct, kImage, 2.0, {.centre_hu = 0, .width_hu = -5}), InputError);
}

}  // namespace
}  // namespace acus::slicing
