#include "acus/patient/phantom/planning/image_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// Soft tissue behind a flat skin at y = 0, with a block of another tissue from x_mm and y_mm.
struct FlatBody {
  explicit FlatBody(const char* tissue = "", double x_mm = 0.0, double y_mm = 0.0)
      : labels(Made(tissue, x_mm, y_mm)), field(labels) {}

  /// 36 mm deep, towards a probe that lies along x.
  ImageView View() const {
    return ViewOf(field, CompletePlan(Vector3d::Zero(), -Vector3d::UnitY(), Vector3d(20.0, 30.0, 0),
                                      Vector3d::UnitX()));
  }

  volume::LabelMap labels;
  LabelMapField field;

 private:
  static volume::LabelMap Made(const char* tissue, double x_mm, double y_mm) {
    volume::Geometry g;
    g.size = {80, 90, 40};
    g.spacing_mm = Eigen::Array3d::Constant(2.0);
    g.origin_mm = {-59.0, -19.0, -39.0};
    volume::LabelMap made(g, 0);
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Vector3d p = g.ct_from_index() * Vector3d(i, j, k);
          if (p.y() < 0.0) continue;
          const bool block = *tissue != 0 && p.x() > x_mm && p.y() > y_mm;
          made.At(i, j, k) = volume::LabelOf(block ? tissue : "soft_tissue");
        }
      }
    }
    return made;
  }
};

TEST(ImageView, OfFreeTissueShowsAllThatIsInTheFan) {
  const ImageView view = FlatBody().View();
  EXPECT_EQ(view.target, 1.0);
  // A needle that enters beside the probe comes into the fan deeper.
  EXPECT_GT(view.needle, 0.5);
  EXPECT_LT(view.needle, 1.0);
  // A curved face lies on flat skin with the beams that are within 3 mm of it: 18 of 30 degrees; 21
  // where the skin is half a voxel higher.
  EXPECT_GE(view.face, 0.60);
  EXPECT_LE(view.face, 0.71);
  EXPECT_TRUE(view.IsGood());
  EXPECT_THAT(ViewText(view), HasSubstr("the target"));
}

TEST(ImageView, EndsAtLungBoneAndGas) {
  for (const char* tissue : {"lung", "bone", "gas"}) {
    const ImageView view = FlatBody(tissue, -60.0, 10.0).View();
    EXPECT_EQ(view.target, 0.0) << tissue;
    EXPECT_LT(view.needle, 0.3) << tissue;
    EXPECT_EQ(view.face, 0.0) << tissue;
    EXPECT_FALSE(view.IsGood());
    EXPECT_THAT(ViewText(view), HasSubstr(tissue));
    EXPECT_GT(view.hidden_by.at(tissue), 20) << tissue;
  }
}

TEST(ImageView, OfAFaceThatIsHalfOnLungHasLessFaceAndStillTheTarget) {
  const ImageView view = FlatBody("lung", 32.0, 5.0).View();
  EXPECT_EQ(view.target, 1.0);
  EXPECT_NEAR(view.face, 0.3, 0.05);
  EXPECT_FALSE(view.IsGood());
}

TEST(ImageView, IsOfNothingWithoutSkinUnderTheProbe) {
  const FlatBody body;
  const InsertionPlan plan = CompletePlan(Vector3d(60.0, 0, 0), -Vector3d::UnitY(),
                                          Vector3d(20.0, 300.0, 0), Vector3d::UnitX());
  EXPECT_EQ(ViewOf(body.field, plan).target, 0.0);
}

}  // namespace
}  // namespace acus::phantom
