#include "acus/imaging/slicing/slab.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "support/synthetic_ct.h"

namespace acus::slicing {
namespace {

const image::ImageGeometry kPlane{.width_px = 61,
                                  .height_px = 45,
                                  .lateral_mm_per_px = 0.7,
                                  .axial_mm_per_px = 0.7,
                                  .depth_of_top_row_mm = -15.4};

Eigen::Isometry3d TiltedPose() {
  return Eigen::Translation3d(30.0, 31.0, 19.0) *
         Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 0.3, -0.2).normalized());
}
volume::CtVolume QuadraticCt() {
  return testing_support::SyntheticCt({60, 60, 40}, 1.0, [](double x, double y, double z) {
    return 3.0 * x - 2.0 * y + 0.2 * (z - 20.0) * (z - 20.0);
  });
}

TEST(Slab, WithoutThicknessIsTheSliceToTheBit) {
  const volume::CtVolume ct = QuadraticCt();
  SlabRenderer slab(ct, kPlane, {});
  CtSliceRenderer slice(ct, kPlane, 2.0);
  image::GrayImage of_slab;
  image::GrayImage of_slice;
  slab.Render(TiltedPose(), {}, of_slab);
  slice.Render(TiltedPose(), {}, of_slice);
  EXPECT_EQ(slab.num_slices(), 1);
  for (int r = 0; r < kPlane.height_px; ++r) {
    for (int c = 0; c < kPlane.width_px; ++c) EXPECT_EQ(slab.hu().row(r)[c], slice.hu().row(r)[c]);
  }
  EXPECT_EQ(of_slab.pixels, of_slice.pixels);
}

TEST(Slab, MeanAndMaximumOfAParabolaAreKnown) {
  // Along z: 0.2 (z - 20)^2 over 12 mm around 17 is at most 0.2 * 9^2, on average 0.2 (9 + 12).
  const volume::CtVolume ct = QuadraticCt();
  const Eigen::Isometry3d pose(Eigen::Translation3d(30.0, 30.0, 17.0));
  image::GrayImage image;
  for (const SlabValue value : {SlabValue::kMean, SlabValue::kMaximum}) {
    SlabRenderer slab(ct, kPlane, {.thickness_mm = 12.0, .value = value, .window = {}});
    slab.Render(pose, {}, image);
    const double of_z_hu = value == SlabValue::kMean ? 0.2 * (9.0 + 12.0) : 0.2 * 8.5 * 8.5;
    for (const auto& [column, row] : {std::pair{0, 0}, {60, 0}, {30, 22}, {0, 44}, {60, 44}}) {
      const double plane_hu = 3.0 * (30.0 + 0.7 * (column - 30)) - 2.0 * (30.0 - 15.4 + 0.7 * row);
      // Voxels are whole HU; slices are in the middle of 12 pieces.
      EXPECT_NEAR(static_cast<double>(slab.hu().row(row)[column]), plane_hu + of_z_hu, 1.0)
          << column << ' ' << row;
    }
    EXPECT_EQ(slab.num_slices(), 12);
  }
}

TEST(Slab, TissueThatMovesIsShownWhereItIs) {
  class Sheared : public RestMap {
   public:
    Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place,
                               const Eigen::Vector3d&) const noexcept override {
      return {place[0] - 0.2 * (place[2] - 20.0), place[1], place[2]};
    }
    double SpacingMm() const noexcept override { return 5.0; }
  };
  const volume::CtVolume ct = testing_support::SyntheticCt(
      {60, 60, 40}, 1.0, [](double x, double, double) { return 10.0 * x; });
  const Sheared rest;
  const Eigen::Isometry3d pose(Eigen::Translation3d(30.0, 30.0, 20.0));
  image::GrayImage image;
  image::GrayImage threaded;
  SlabRenderer slab(ct, kPlane, {.thickness_mm = 16.0, .value = SlabValue::kMaximum, .window = {}});
  slab.Render(pose, {}, image, 1, &rest);
  // The most is where the shear comes from 8 mm below: within what 2 mm of slices share.
  const double truth_hu = 10.0 * (30.0 + 0.2 * 7.5);
  EXPECT_NEAR(static_cast<double>(slab.hu().row(22)[30]), truth_hu,
              10.0 * 0.2 * SlabRenderer::kSameRestMm + 0.6);
  slab.Render(pose, {}, threaded, 3, &rest);
  EXPECT_EQ(image.pixels, threaded.pixels);
}

TEST(Slab, ANeedleWithinItIsDrawn) {
  const volume::CtVolume ct = QuadraticCt();
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = {30.0, 30.0, 24.0};
  needle.axis_in_ct = Eigen::Vector3d::UnitX();
  needle.length_mm = 15.0;
  needle.radius_mm = 0.6;
  const Eigen::Isometry3d pose(Eigen::Translation3d(30.0, 30.0, 20.0));
  image::GrayImage image;
  SlabRenderer thick(ct, kPlane, {.thickness_mm = 12.0, .value = SlabValue::kMean, .window = {}});
  thick.Render(pose, needle, image);
  EXPECT_EQ(image.At(20, 22), 255);
  SlabRenderer thin(ct, kPlane, {});
  thin.Render(pose, needle, image);
  EXPECT_LT(image.At(20, 22), 255);
}

TEST(Slab, RefusesWhatItCannotRender) {
  const volume::CtVolume ct = QuadraticCt();
  EXPECT_THROW(SlabRenderer(ct, kPlane, {.thickness_mm = -1.0}), InputError);
  EXPECT_THROW(SlabRenderer(ct, kPlane, {.thickness_mm = std::nan("")}), InputError);
  EXPECT_THROW(SlabRenderer(ct, kPlane, {.window = {.centre_hu = 0.0, .width_hu = 0.0}}),
               InputError);
  EXPECT_THROW(SlabRenderer(ct, {}, {}), InputError);
}

}  // namespace
}  // namespace acus::slicing
