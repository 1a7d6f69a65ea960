#include "acus/patient/segmentation/voxels/scan_field.h"

#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "synthetic_body.h"

namespace acus::segmentation {
namespace {

constexpr double kRadiusMm = 78.0;  // The body is 180 mm wide.

/// The body as a scanner with a round field of view sees it.
volume::CtVolume SeenInCircle(volume::CtVolume ct, std::int16_t padding_hu, double radius_mm) {
  const volume::Geometry& g = ct.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        if (p.head<2>().norm() > radius_mm) ct.At(i, j, k) = padding_hu;
      }
    }
  }
  return ct;
}

/// Means over 3 x 3 voxels of a slice, twice: edges of a body as a scanner shows them.
volume::CtVolume Blurred(volume::CtVolume ct) {
  const auto& size = ct.geometry.size;
  for (int round = 0; round < 2; ++round) {
    const volume::CtVolume before = ct;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 1; j + 1 < size[1]; ++j) {
        for (int i = 1; i + 1 < size[0]; ++i) {
          int sum = 0;
          for (int d = 0; d < 9; ++d) sum += before.At(i - 1 + d % 3, j - 1 + d / 3, k);
          ct.At(i, j, k) = static_cast<std::int16_t>(sum / 9);
        }
      }
    }
  }
  return ct;
}

TissueOptions DefaultTissues() {
  return ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json").tissues;
}

void ExpectTheCircle(const volume::CtVolume& ct) {
  const ScanField field = FindScanField(ct);
  ASSERT_TRUE(field.circle);
  EXPECT_NEAR(field.circle->radius_mm, kRadiusMm, 1.0);
  const Eigen::Vector2d centre = -ct.geometry.origin_mm.head<2>();
  EXPECT_LT((field.circle->centre_mm - centre).norm(), 1.0);
}

TEST(ScanField, FindsTheCircleInNoisyAir) {
  ExpectTheCircle(SeenInCircle(MakeSyntheticBody({}).ct, -1024, kRadiusMm));
}

TEST(ScanField, FindsTheCircleWhereAirIsAsEvenAsPadding) {
  volume::CtVolume ct = Blurred(MakeSyntheticBody({.has_table = false}).ct);
  for (auto& hu : ct.voxels) {
    if (hu < -950) hu = -1000;
  }
  ExpectTheCircle(SeenInCircle(ct, -1000, kRadiusMm));
}

TEST(ScanField, ABodyThatIsSeenAsAWholeHasNoCircle) {
  const SyntheticBody body = MakeSyntheticBody({.noise_hu = 0.0, .has_table = false});
  const ScanField field = FindScanField(body.ct);
  ASSERT_TRUE(field.padding_hu);
  EXPECT_EQ(*field.padding_hu, -1000);
  EXPECT_FALSE(field.circle) << field.circle->radius_mm;
  EXPECT_FALSE(FindScanField(MakeSyntheticBody({}).ct).circle);
}

TEST(ScanField, WhatTheCircleCutsIsNoSkin) {
  const SyntheticBody body = MakeSyntheticBody({});
  const auto found = FindTissues(SeenInCircle(body.ct, -1024, kRadiusMm), DefaultTissues(), {});
  const volume::LabelMap& labels = found.labels;
  const volume::Geometry& g = labels.geometry;
  const auto skin = volume::LabelOf("skin");
  const auto cut = volume::LabelOf("cut");
  std::size_t num_cut = 0, num_skin = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        const double from_circle_mm = kRadiusMm - p.head<2>().norm();
        const double from_ellipse = 1.0 - std::hypot(p.x() / 90.0, p.y() / 64.0);
        const auto label = labels.At(i, j, k);
        // Well inside the body's outline: only the scanner can have ended there.
        if (from_ellipse > 0.08 && label == skin) ADD_FAILURE() << p.transpose();
        if (label == cut) {
          ++num_cut;
          EXPECT_LT(from_circle_mm, 4.0);
        }
        if (label == skin) ++num_skin;
      }
    }
  }
  EXPECT_GT(num_cut, 500U);
  EXPECT_GT(num_skin, num_cut);
  EXPECT_EQ(labels.names.at(cut), "cut");
}

TEST(ScanField, ALungThatTheCircleCutsIsInTheBody) {
  // The lung reaches from 23 to 67 mm to the right.
  const SyntheticBody body = MakeSyntheticBody({});
  const auto found = FindTissues(SeenInCircle(body.ct, -1024, 58.0), DefaultTissues(), {}).labels;
  const Eigen::Array3i in_lung =
      (found.geometry.index_from_ct() * Eigen::Vector3d(-45, -15, 30)).array().round().cast<int>();
  EXPECT_EQ(found.At(in_lung[0], in_lung[1], in_lung[2]), volume::LabelOf("lung"));
}

TEST(ScanField, DensePaddingIsAir) {
  const SyntheticBody body = MakeSyntheticBody({});
  const auto usual = FindTissues(SeenInCircle(body.ct, -1024, kRadiusMm), DefaultTissues(), {});
  const auto dense = FindTissues(SeenInCircle(body.ct, 0, kRadiusMm), DefaultTissues(), {});
  EXPECT_EQ(usual.labels.voxels, dense.labels.voxels);
}

TEST(ScanField, NoPaddingIsInventedForABodyThatFillsItsVolume) {
  volume::Geometry g;
  g.size = {40, 40, 10};
  g.spacing_mm = {3.0, 3.0, 3.0};
  volume::CtVolume ct(g, 40);
  ct.At(0, 0, 0) = 41;
  EXPECT_FALSE(FindScanField(ct).padding_hu);
  EXPECT_FALSE(WithoutDensePadding(ct, FindScanField(ct), -300.0, 1));
}

}  // namespace
}  // namespace acus::segmentation
