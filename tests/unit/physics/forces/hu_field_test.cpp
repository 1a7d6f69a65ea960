#include "acus/physics/forces/laws/hu_field.h"

#include <gmock/gmock.h>
#include <limits>

#include "acus/physics/forces/laws/tissue_lookup.h"
#include "acus/physics/forces/models/model_settings.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;

/// HU = 10 i + 20 j - 5 k on an oblique grid.
volume::CtVolume LinearCt() {
  volume::Geometry geometry;
  geometry.size = {12, 10, 8};
  geometry.spacing_mm = {0.8, 1.1, 2.0};
  geometry.origin_mm = {-30.0, 12.0, 5.0};
  geometry.direction = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  volume::CtVolume ct(geometry);
  for (int k = 0; k < 8; ++k) {
    for (int j = 0; j < 10; ++j) {
      for (int i = 0; i < 12; ++i)
        ct.At(i, j, k) = static_cast<std::int16_t>(10 * i + 20 * j - 5 * k);
    }
  }
  return ct;
}

TEST(CtField, IsExactForALinearCtAndItsGradient) {
  const volume::CtVolume ct = LinearCt();
  const CtField field(ct);
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  const Vector3d index(4.3, 5.8, 3.25);
  EXPECT_NEAR(field.HuAt(ct_from_index * index), 43.0 + 116.0 - 16.25, 1e-9);
  EXPECT_EQ(field.ResolutionMm(), 0.8);
  const Vector3d expected = ct.geometry.direction * Vector3d(10.0 / 0.8, 20.0 / 1.1, -5.0 / 2.0);
  EXPECT_TRUE(field.GradientHuPerMm(ct_from_index * index).isApprox(expected, 1e-9));
}

TEST(CtField, EndsHalfAVoxelBeyondTheOutermostCentres) {
  const volume::CtVolume ct = LinearCt();
  const CtField field(ct);
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  EXPECT_NEAR(field.HuAt(ct_from_index * Vector3d(-0.49, 0.0, 0.0)), 0.0, 1e-9);
  EXPECT_EQ(field.HuAt(ct_from_index * Vector3d(-0.51, 0.0, 0.0)), HuField::kOutsideHu);
  EXPECT_NEAR(field.HuAt(ct_from_index * Vector3d(11.49, 9.4, 7.4)), 110.0 + 180.0 - 35.0, 1e-9);
  EXPECT_EQ(field.HuAt(ct_from_index * Vector3d(11.0, 9.0, 7.6)), HuField::kOutsideHu);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(field.HuAt(Vector3d(nan, 0, 0)), HuField::kOutsideHu);
  EXPECT_EQ(field.HuAt(Vector3d(1e300, 0, 0)), HuField::kOutsideHu);
}

TEST(HuField, FindsTheFirstCrossing) {
  const volume::CtVolume ct = LinearCt();
  const CtField field(ct);
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  const Vector3d from = ct_from_index * Vector3d(1, 2, 2);  // 40 HU.
  const Vector3d to = ct_from_index * Vector3d(9, 6, 2);    // 200 HU.
  EXPECT_NEAR(field.FirstCrossing(from, to, 120.0), 0.5, 1e-3);
  EXPECT_GT(field.FirstCrossing(from, to, 201.0), 1.0);
  EXPECT_EQ(field.FirstCrossing(to, from, 120.0), 0.0);  // Above it already.
  EXPECT_GT(field.FirstCrossing(from, from, 120.0), 1.0);
}

TEST(TissueLookup, GoesByLabelsOrByHu) {
  const volume::CtVolume ct = LinearCt();
  volume::LabelMap labels(ct.geometry, volume::LabelOf("liver"));
  labels.At(3, 4, 5) = volume::LabelOf("bone");
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  const TissueLookup by_label(labels);
  EXPECT_EQ(by_label.At(ct_from_index * Vector3d(3.4, 4.4, 4.6)), volume::LabelOf("bone"));
  EXPECT_EQ(by_label.At(ct_from_index * Vector3d(3.6, 4.0, 5.0)), volume::LabelOf("liver"));
  EXPECT_EQ(by_label.At(ct_from_index * Vector3d(-1.0, 4.0, 5.0)), 0);
  EXPECT_EQ(by_label.At(Vector3d(NAN, 0, 0)), 0);

  const CtField field(ct);
  const HuTissues tissues{{{50.0, volume::LabelOf("fat")}, {100.0, volume::LabelOf("muscle")}}};
  const TissueLookup by_hu(field, tissues);
  EXPECT_EQ(by_hu.At(ct_from_index * Vector3d(1, 1, 0)), 0);
  EXPECT_EQ(by_hu.At(ct_from_index * Vector3d(5, 0, 0)), volume::LabelOf("fat"));
  EXPECT_EQ(by_hu.At(ct_from_index * Vector3d(5, 4, 0)), volume::LabelOf("muscle"));
  EXPECT_EQ(by_hu.At(Vector3d(NAN, 0, 0)), 0);
}

}  // namespace
}  // namespace acus::forces
