#include "acus/patient/phantom/anatomy/patient_field.h"

#include <cmath>
#include <gtest/gtest.h>

#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

TEST(LabelMapField, GivesTheNearestVoxelAndNothingBeyondTheVolume) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  EXPECT_EQ(field.LabelAt(Vector3d(0, 0, 0)), volume::LabelOf("soft_tissue"));
  EXPECT_EQ(field.LabelAt(Vector3d(0, -70, 0)), volume::LabelOf("bone"));
  EXPECT_EQ(field.LabelAt(Vector3d(0, 0, 500)), 0);
}

TEST(LabelMapField, TheLabelCutIsACut) {
  volume::LabelMap labels = SyntheticBody({150, 120, 30}, 2.0);
  const auto cut = volume::LabelOf("cut");
  labels.names[cut] = "cut";
  const volume::Geometry& g = labels.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
        const bool outer = std::hypot(p.x() / 140.0, p.y() / 105.0) > 0.97;
        if (labels.At(i, j, k) != 0 && outer && p.x() > 0.0) labels.At(i, j, k) = cut;
      }
    }
  }
  const LabelMapField field(labels);
  EXPECT_TRUE(field.IsCut({140.0, 0.0, 3.0}));
  EXPECT_TRUE(field.IsCut({100.0, 73.0, 3.0}));
  EXPECT_FALSE(field.IsCut({-140.0, 0.0, 3.0}));
  EXPECT_FALSE(field.IsCut({-100.0, 73.0, 3.0}));
}

TEST(LabelMapField, SmoothsTheStairsOfItsVoxels) {
  const volume::LabelMap labels = SyntheticBody({150, 120, 30}, 2.0);
  const LabelMapField field(labels);
  for (double angle = 0.0; angle < 6.28; angle += 0.05) {
    const Vector3d truth(140.0 * std::sin(angle), 105.0 * std::cos(angle), 3.0);
    const Vector3d normal =
        Vector3d(truth.x() / (140.0 * 140.0), truth.y() / (105.0 * 105.0), 0.0).normalized();
    const auto skin = SkinAlong(field, truth, normal, 20.0);
    ASSERT_TRUE(skin.has_value());
    EXPECT_NEAR((*skin - truth).dot(normal), 0.0, 1.05) << "at " << angle;  // Half a voxel.
    EXPECT_GT(SkinNormal(field, *skin).dot(normal), std::cos(0.15)) << "at " << angle;
  }
}

TEST(LabelMapField, SeesNoSkinWhereTheFieldOfViewCutsTheBody) {
  // The body reaches the volume's border: there is no way out of it along x.
  const volume::LabelMap labels = SyntheticBody({40, 70, 30}, 4.0);
  const LabelMapField field(labels);
  EXPECT_FALSE(SkinAlong(field, Vector3d(60, 0, 0), Vector3d::UnitX(), 200.0).has_value());
  EXPECT_TRUE(SkinAlong(field, Vector3d(0, 60, 0), Vector3d::UnitY(), 200.0).has_value());
}

TEST(SkinAlong, FindsTheNearestCrossingFromEitherSide) {
  const volume::LabelMap labels = SyntheticBody();
  const LabelMapField field(labels);
  for (const double start : {60.0, 100.0, 110.0, 150.0}) {
    const auto skin = SkinAlong(field, Vector3d(0, start, 0), Vector3d::UnitY(), 80.0);
    ASSERT_TRUE(skin.has_value()) << start;
    EXPECT_NEAR(skin->y(), 105.0, 2.5);
  }
  EXPECT_FALSE(SkinAlong(field, Vector3d(0, 60, 0), Vector3d::UnitY(), 30.0).has_value());
}

TEST(AnatomyField, HasTheSkinOfTheAnatomy) {
  const PhantomConfig config = Preset("lumbar");
  const Anatomy anatomy(config.body, 1);
  const AnatomyField field(anatomy, config.grid);
  const auto skin = SkinAlong(field, Vector3d(20, 60, 0), Vector3d::UnitY(), 40.0);
  ASSERT_TRUE(skin.has_value());
  EXPECT_EQ(field.LabelAt(*skin + Vector3d(0, 0.01, 0)), 0);
  EXPECT_EQ(field.LabelAt(*skin - Vector3d(0, 0.01, 0)), volume::LabelOf("skin"));
}

/// A body wider than the circle of reconstruction, or a narrower one, cut by nothing.
volume::LabelMap BodyInACircle(double half_width_mm) {
  volume::Geometry g;
  g.size = {100, 100, 10};
  g.spacing_mm = {3.0, 3.0, 5.0};
  g.origin_mm = {-148.5, -148.5, 0.0};
  volume::LabelMap labels(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
        const bool in_body = std::hypot(p.x() / half_width_mm, p.y() / 100.0) < 1.0;
        if (in_body && std::hypot(p.x(), p.y()) < 150.0)
          labels.At(i, j, k) = volume::LabelOf("soft_tissue");
      }
    }
  }
  return labels;
}

TEST(LabelMapField, FindsWhereTheCircleOfReconstructionCutsTheBody) {
  const volume::LabelMap wide = BodyInACircle(220.0);
  const LabelMapField cut(wide);
  EXPECT_TRUE(cut.IsCut({149.0, 0.0, 20.0}));
  EXPECT_FALSE(cut.IsCut({0.0, 100.0, 20.0})) << "skin";
  EXPECT_FALSE(LabelMapField(wide, LabelMapField::Beyond::kAir).IsCut({149.0, 0.0, 20.0}));
  const volume::LabelMap narrow = BodyInACircle(140.0);
  EXPECT_FALSE(LabelMapField(narrow).IsCut({149.0, 0.0, 20.0}));
}

}  // namespace
}  // namespace acus::phantom
