#include "acus/imaging/slicing/label_slice.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/data/volume/label_lookup.h"

namespace acus::slicing {
namespace {

const image::ImageGeometry kLabelImage{.width_px = 301,
                                       .height_px = 90,
                                       .lateral_mm_per_px = 0.2,
                                       .axial_mm_per_px = 0.5,
                                       .depth_of_top_row_mm = -3.0};

/// Another label in each voxel around, on oblique axes.
volume::LabelMap Chequered() {
  volume::Geometry geometry;
  geometry.size = {40, 30, 25};
  geometry.spacing_mm = {1.5, 1.1, 2.0};
  geometry.origin_mm = {-20.0, -10.0, -15.0};
  geometry.direction =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  volume::LabelMap labels(geometry);
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    labels.voxels[n] = static_cast<volume::Label>(1 + n * 7 % 200);
  }
  return labels;
}

Eigen::Isometry3d ObliquePose() {
  return Eigen::Translation3d(8.0, 3.0, -5.0) *
         Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, -1.0, 0.5).normalized());
}

/// Off the borders of voxels by so much that rounding does not matter.
bool IsClear(const Eigen::Vector3d& index) {
  const Eigen::Vector3d off = (index.array() - index.array().floor() - 0.5).abs();
  return off.minCoeff() > 1e-3;
}

/// Tissue that has moved as a whole, and is turned a little.
class TurnedTissue : public RestMap {
 public:
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& /*guess*/) const noexcept override {
    return turn_ * place_in_ct_mm + Eigen::Vector3d(2.0, -3.0, 1.5);
  }
  double SpacingMm() const noexcept override { return 3.0; }

 private:
  Eigen::AngleAxisd turn_{0.05, Eigen::Vector3d::UnitY()};
};

/// Compares every pixel with the label map at its place in the CT. @returns pixels in the map.
int ExpectLabelsOfTheMap(const RestMap* rest) {
  const volume::LabelMap labels = Chequered();
  LabelSlice slice(labels, kLabelImage);
  image::GrayImage image;
  slice.Render(ObliquePose(), rest, image);
  const Eigen::Affine3d ct_from_image = kLabelImage.ct_from_image(ObliquePose());
  const Eigen::Affine3d index_from_ct = labels.geometry.index_from_ct();
  int inside = 0;
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      const Eigen::Vector3d place_mm = ct_from_image * Eigen::Vector3d(c, r, 0);
      const Eigen::Vector3d rest_mm = rest ? rest->RestInCtMm(place_mm, place_mm) : place_mm;
      EXPECT_LT((slice.RestOfPixelMm(c, r) - rest_mm).norm(), 1e-4);
      if (!IsClear(index_from_ct * rest_mm)) continue;
      const int expected = volume::LabelAt(labels, index_from_ct, rest_mm);
      EXPECT_EQ(image.At(c, r), expected) << c << ' ' << r;
      if (expected != 0) ++inside;
    }
  }
  return inside;
}

TEST(LabelSlice, EachPixelHasTheLabelOfItsPlace) {
  EXPECT_GT(ExpectLabelsOfTheMap(nullptr), 5000);
}

TEST(LabelSlice, EachPixelHasTheLabelOfItsPlaceAtRest) {
  const TurnedTissue tissue;
  EXPECT_GT(ExpectLabelsOfTheMap(&tissue), 5000);
}

TEST(LabelSlice, ASphereIsMarkedWhereItsTissueIs) {
  const volume::LabelMap labels = Chequered();
  const TurnedTissue tissue;
  LabelSlice slice(labels, kLabelImage);
  image::GrayImage image;
  slice.Render(ObliquePose(), &tissue, image);
  const Eigen::Vector3d centre_mm = slice.RestOfPixelMm(150, 40) + Eigen::Vector3d(0.4, 0.3, -0.2);
  slice.MarkSphere(centre_mm, 4.0, 250, image);
  int marked = 0;
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      const double off_mm = (slice.RestOfPixelMm(c, r) - centre_mm).norm();
      if (std::abs(off_mm - 4.0) < 1e-3) continue;
      EXPECT_EQ(image.At(c, r) == 250, off_mm < 4.0) << c << ' ' << r;
      if (image.At(c, r) == 250) ++marked;
    }
  }
  EXPECT_GT(marked, 300);
}

TEST(LabelSlice, ASphereAroundTheImageMarksEveryPixel) {
  const volume::LabelMap labels = Chequered();
  LabelSlice slice(labels, kLabelImage);
  image::GrayImage image;
  slice.Render(ObliquePose(), nullptr, image);
  slice.MarkSphere(slice.RestOfPixelMm(100, 40), 1000.0, 250, image);
  EXPECT_THAT(image.pixels, ::testing::Each(250));
}

TEST(LabelSlice, RefusesAPoseThatIsNotFinite) {
  const volume::LabelMap labels = Chequered();
  LabelSlice slice(labels, kLabelImage);
  image::GrayImage image;
  Eigen::Isometry3d pose = ObliquePose();
  pose.translation().x() = std::nan("");
  EXPECT_THROW(slice.Render(pose, nullptr, image), InputError);
}

}  // namespace
}  // namespace acus::slicing
