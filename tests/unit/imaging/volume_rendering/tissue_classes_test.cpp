#include "acus/imaging/volume_rendering/tissue_classes.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const volume::Label kLiver = volume::LabelOf("liver");

/// A body of 60 HU, the same everywhere, with a ball that only the labels know.
struct LabelledBall {
  std::shared_ptr<volume::CtVolume> ct;
  std::shared_ptr<volume::LabelMap> labels;

  explicit LabelledBall(double radius_mm) {
    volume::Geometry grid;
    grid.size = {64, 60, 56};
    grid.spacing_mm = {2.0, 2.0, 2.5};
    grid.origin_mm = {-63, -59, -69};
    ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{60});
    labels = std::make_shared<volume::LabelMap>(grid, volume::LabelOf("muscle"));
    const Eigen::Affine3d ct_from_index = grid.ct_from_index();
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const double from_middle_mm = (ct_from_index * Eigen::Vector3d(i, j, k)).norm();
          if (from_middle_mm < radius_mm) labels->At(i, j, k) = kLiver;
        }
      }
    }
  }

  ViewImage Image(const breathing::MotionMap* motion = nullptr) const {
    PatientView view({.ct = ct,
                      .layers = {{"liver", 1.0}},
                      .surfaces = {},
                      .field = motion == nullptr ? nullptr : &motion->field(),
                      .labels = labels},
                     {});
    const Camera camera =
        LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}}, {160, 160});
    ViewImage out;
    view.Render(camera, {.motion = motion}, out, 2);
    return out;
  }
};

// All has the same HU: nothing but the label says where the liver is.
TEST(TissueClasses, ATissueHasItsOwnFunctionWhereItIs) {
  const double radius_mm = 30.0;
  const auto blob = testing_support::CoveredPart(LabelledBall(radius_mm).Image());
  const Camera camera =
      LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}}, {160, 160});
  EXPECT_LT((blob.middle_px - camera.ProjectPx({0, 0, 0})).norm(), 0.3);
  const double px_per_mm = camera.focal_px[0] / camera.EyeInCtMm().norm();
  // The shares of pixels at the rim, where rays are short in it, are less than one.
  EXPECT_LT(blob.diameter_px, 2.0 * radius_mm * px_per_mm * 1.02);
  EXPECT_GT(blob.diameter_px, 2.0 * radius_mm * px_per_mm * 0.85);
}

TEST(TissueClasses, BreatheWithThePatient) {
  const Eigen::Vector3d shift_mm(8.0, 0.0, -12.0);
  const auto field = testing_support::FieldOf([&](const Eigen::Vector3d&) { return shift_mm; }, 12);
  const auto motion = testing_support::At(field, 1.0);
  const Camera camera =
      LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}}, {160, 160});
  const auto blob = testing_support::CoveredPart(LabelledBall(25.0).Image(&motion));
  EXPECT_LT((blob.middle_px - camera.ProjectPx(shift_mm)).norm(), 0.3);
}

// A border of labels goes over from one voxel to the next by shares: the silhouette of a ball has
// no steps of a voxel.
TEST(TissueClasses, ABorderHasNoSteps) {
  const ViewImage image = LabelledBall(30.0).Image();
  int partly = 0;
  int fully = 0;
  for (const std::uint8_t coverage : image.coverage) {
    partly += coverage > 20 && coverage < 160;
    fully += coverage >= 160;
  }
  EXPECT_GT(fully, 500);
  EXPECT_GT(partly, 100);
}

TEST(TissueClasses, OfOtherTissuesNothingIsSeen) {
  const LabelledBall none(0.0);
  const ViewImage image = none.Image();
  EXPECT_EQ(std::ranges::count(image.coverage, 0),
            static_cast<std::ptrdiff_t>(image.coverage.size()));
}

TEST(TissueClasses, NeedALabelMap) {
  const LabelledBall ball(30.0);
  EXPECT_THAT(
      [&] {
        PatientView({.ct = ball.ct, .layers = {{"liver", 1.0}}, .surfaces = {}}, {});
      },
      ThrowsMessage<InputError>(HasSubstr("label map")));
}

TEST(TissueClasses, KnowWhichAreInABox) {
  volume::Geometry grid;
  grid.size = {4, 4, 4};
  volume::LabelMap labels(grid, 0);
  labels.At(2, 1, 3) = kLiver;
  TissueClasses::ClassOfLabel class_of{};
  class_of[kLiver] = 5;
  const TissueClasses classes(grid, labels, class_of);
  EXPECT_EQ(classes.In({0, 0, 0}, {3, 3, 2}), 1U);
  EXPECT_EQ(classes.In({0, 0, 0}, {3, 3, 3}), 1U | 1U << 5U);
  EXPECT_EQ(classes.In({2, 1, 3}, {2, 1, 3}), 1U << 5U);
  EXPECT_EQ(TissueClasses().In({0, 0, 0}, {3, 3, 3}), 1U);
  // Labels on a grid of half the spacing, of which every second voxel is one of the CT's.
  volume::Geometry fine = grid;
  fine.size = {8, 8, 8};
  fine.spacing_mm.setConstant(0.5);
  volume::LabelMap fine_labels(fine, 0);
  fine_labels.At(4, 2, 6) = kLiver;
  EXPECT_EQ(TissueClasses(grid, fine_labels, class_of).In({2, 1, 3}, {2, 1, 3}), 1U << 5U);
}

}  // namespace
}  // namespace acus::volume_rendering
