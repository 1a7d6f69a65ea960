#include "acus/scene/simulation/image_labels.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/imaging/acoustics/field_of_view.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "support/breathing_patients.h"
#include "support/layered_scene.h"

namespace acus::simulation {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// In the plane x = 0: +x of the probe is +y of the CT, its beam +z.
Eigen::Isometry3d LabelledPose() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return pose;
}

Eigen::Isometry3d NeedleAt(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis.normalized()).matrix();
  pose.translation() = tip_mm;
  return pose;
}

class ImageLabelsTest : public testing::Test {
 protected:
  ImageTruth Truth(const Snapshot& snapshot, const ImageLabelSettings& settings = {}) {
    ImageLabeller labeller(scene_, scene_.labels, settings);
    image_ = labeller.image();
    depth_mm_ = labeller.depth_mm();
    ImageTruth truth;
    labeller.Label(snapshot, truth);
    return truth;
  }

  Snapshot At(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) const {
    return {.probe_valid = true,
            .ct_from_probe = LabelledPose(),
            .ct_from_needle = NeedleAt(tip_mm, axis)};
  }

  /// Of a pixel, in CT space.
  Eigen::Vector3d PlaceMm(int c, int r) const {
    return image_.ct_from_image(LabelledPose()) * Eigen::Vector3d(c, r, 0);
  }

  template <typename Visit>
  void ForEachPixel(const ImageTruth& truth, const Visit& visit) const {
    for (int r = 0; r < truth.labels.height; ++r) {
      for (int c = 0; c < truth.labels.width; ++c) visit(c, r, truth.labels.At(c, r));
    }
  }

  Scene scene_ =
      testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
  image::ImageGeometry image_;
  std::vector<float> depth_mm_;
};

TEST_F(ImageLabelsTest, TissuesAreThoseOfTheMap) {
  // Off the border of voxels at x = 0.
  const Eigen::Isometry3d pose = Eigen::Translation3d(0.2, 0.0, 0.0) * LabelledPose();
  const ImageTruth truth = Truth({.probe_valid = true, .ct_from_probe = pose});
  const Eigen::Affine3d index_from_ct = scene_.labels->geometry.index_from_ct();
  int tissue = 0;
  ForEachPixel(truth, [&](int c, int r, int label) {
    const Eigen::Vector3d place_mm = image_.ct_from_image(pose) * Eigen::Vector3d(c, r, 0);
    const Eigen::Vector3d in_probe_mm = pose.inverse() * place_mm;
    if (!acoustics::IsInFieldOfView(*scene_.probe, in_probe_mm.head<2>())) {
      EXPECT_EQ(label, kBeyondImage);
      return;
    }
    const Eigen::Vector3d index = index_from_ct * place_mm;
    if ((index.array() - index.array().floor() - 0.5).abs().minCoeff() < 1e-3) return;
    EXPECT_EQ(label, volume::LabelAt(*scene_.labels, index_from_ct, place_mm)) << c << ' ' << r;
    if (label != 0) ++tissue;
  });
  EXPECT_GT(tissue, 10'000);
  EXPECT_FALSE(truth.tip_in_image);
  EXPECT_FALSE(truth.visible_share);
}

TEST_F(ImageLabelsTest, NeedlePixelsLieOnTheNeedleAndTheTipsAtItsTip) {
  const Eigen::Vector3d tip_mm(0.3, 6.0, 28.0);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.0, 0.5, 1.0).normalized();
  const ImageTruth truth = Truth(At(tip_mm, axis));
  const double pixel_mm = image_.lateral_mm_per_px;
  int shaft = 0, tip = 0;
  ForEachPixel(truth, [&](int c, int r, int label) {
    const Eigen::Vector3d from_tip_mm = PlaceMm(c, r) - tip_mm;
    const Eigen::Vector2d off_tip_mm = from_tip_mm.tail<2>();
    const double along_mm = -from_tip_mm.dot(axis);
    const double aside_mm = (from_tip_mm + along_mm * axis).tail<2>().norm();
    if (label == kShaftInImage) {
      ++shaft;
      EXPECT_LT(aside_mm, 0.5 * scene_.needle->beam.outer_diameter_mm + pixel_mm) << c << ' ' << r;
      EXPECT_GT(along_mm, 0.0);
    }
    if (label == kTipInImage) ++tip;
    if (label != kBeyondImage) {
      EXPECT_EQ(label == kTipInImage, off_tip_mm.norm() <= 1.5) << c << ' ' << r;
    }
    // ... and no pixel on the axis is missing.
    if (label != kBeyondImage && along_mm > 2.0 && aside_mm < 0.25 * pixel_mm) {
      EXPECT_EQ(label, kShaftInImage) << c << ' ' << r;
    }
  });
  EXPECT_GT(shaft, 100);
  EXPECT_GT(tip, 20);
  ASSERT_TRUE(truth.tip_in_image);
  const Eigen::Vector3d seen_mm =
      image_.ct_from_image(LabelledPose()) *
      Eigen::Vector3d(truth.tip_in_image->x(), truth.tip_in_image->y(), 0.0);
  EXPECT_NEAR(seen_mm.y(), tip_mm.y(), 1e-9);
  EXPECT_NEAR(seen_mm.z(), tip_mm.z(), 1e-9);
  EXPECT_NEAR(truth.tip_in_image->z(), 0.3, 1e-9);
  EXPECT_NEAR(truth.inserted_mm, 28.0 / axis.z(), 1.0);
  EXPECT_EQ(truth.visible_share, 1.0);
}

TEST_F(ImageLabelsTest, ANeedleThatCrossesThePlaneIsVisibleByTheShareInTheSlice) {
  // 60 degrees off the plane, its tip 10 mm behind it.
  const Eigen::Vector3d axis(std::sin(1.0471975512), 0.0, std::cos(1.0471975512));
  const Eigen::Vector3d tip_mm(10.0, 0.0, 30.0);
  const ImageTruth truth = Truth(At(tip_mm, axis));
  const double half_mm =
      0.5 * scene_.probe->slice_thickness_mm + 0.5 * scene_.needle->beam.outer_diameter_mm;
  const double inserted_mm = std::min(30.0 / axis.z(), (30.0 + 10.0) / axis.x());
  const double expected = 2.0 * half_mm / axis.x() / inserted_mm;
  ASSERT_TRUE(truth.visible_share);
  EXPECT_NEAR(*truth.visible_share, expected, 2.0 / inserted_mm);
  EXPECT_NEAR(truth.tip_in_image->z(), 10.0, 1e-9);
  ForEachPixel(truth, [&](int, int, int label) { EXPECT_NE(label, kTipInImage); });
}

TEST_F(ImageLabelsTest, OfANeedleAlmostInThePlaneThePartWithinTheSliceIsVisible) {
  constexpr double kOffRad = 0.15;
  const Eigen::Vector3d axis(std::sin(kOffRad), 0.0, std::cos(kOffRad));
  const ImageTruth truth = Truth(At({2.5, 0.0, 34.0}, axis));
  const double half_mm =
      0.5 * scene_.probe->slice_thickness_mm + 0.5 * scene_.needle->beam.outer_diameter_mm;
  ASSERT_TRUE(truth.visible_share);
  EXPECT_NEAR(*truth.visible_share * truth.inserted_mm, 2.0 * half_mm / axis.x(), 1.0);
}

TEST_F(ImageLabelsTest, ANeedleBesideThePlaneIsInNoPixel) {
  const ImageTruth truth = Truth(At({8.0, 0.0, 30.0}, Eigen::Vector3d::UnitZ()));
  ForEachPixel(truth, [&](int, int, int label) {
    EXPECT_TRUE(label != kShaftInImage && label != kTipInImage);
  });
  EXPECT_EQ(truth.visible_share, 0.0);
}

TEST_F(ImageLabelsTest, TheTargetIsADiscAtItsPlace) {
  ImageLabelSettings settings;
  settings.target_ct_mm = Eigen::Vector3d(1.0, -4.0, 25.0);
  settings.target_radius_mm = 3.0;
  const ImageTruth truth = Truth({.probe_valid = true, .ct_from_probe = LabelledPose()}, settings);
  int marked = 0;
  ForEachPixel(truth, [&](int c, int r, int label) {
    const double off_mm = (PlaceMm(c, r) - *settings.target_ct_mm).norm();
    if (label == kBeyondImage || std::abs(off_mm - 3.0) < 1e-3) return;
    EXPECT_EQ(label == kTargetInImage, off_mm < 3.0) << c << ' ' << r;
    if (label == kTargetInImage) ++marked;
  });
  EXPECT_GT(marked, 100);
  ASSERT_TRUE(truth.target_in_image);
  EXPECT_NEAR(truth.target_in_image->z(), 1.0, 1e-9);
}

TEST_F(ImageLabelsTest, TissueAndTargetMoveWithBreath) {
  const testing_support::BreathingPatient patient{.nodes_per_axis = 24,
                                                  .box = testing_support::LayeredGeometry()};
  scene_.breathing = patient.Make();
  scene_.breathing->inverse_iterations = 60;
  scene_.breathing->warp_spacing_mm = 0.5;
  ImageLabelSettings settings;
  settings.target_ct_mm = Eigen::Vector3d(0.0, 2.0, 45.0);
  const Snapshot breathed_out{
      .session_s = 2.0, .probe_valid = true, .ct_from_probe = LabelledPose()};
  const ImageTruth truth = Truth(breathed_out, settings);
  const auto motion = scene_.breathing->At(breathed_out.session_s, breathed_out.breath);
  const Eigen::Vector3d moved_mm =
      *settings.target_ct_mm + motion.DisplacementMm(*settings.target_ct_mm);
  ASSERT_GT((moved_mm - *settings.target_ct_mm).norm(), 5.0) << "the patient does not breathe";
  ASSERT_TRUE(truth.target_in_image);
  const Eigen::Vector3d seen_mm = LabelledPose().inverse() * moved_mm;
  const Eigen::Vector3d found_mm =
      image_.probe_from_image() *
      Eigen::Vector3d(truth.target_in_image->x(), truth.target_in_image->y(), 0.0);
  EXPECT_LT((found_mm.head<2>() - seen_mm.head<2>()).norm(), 0.1);
  // The middle of the marked pixels is there, too.
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  int marked = 0;
  ForEachPixel(truth, [&](int c, int r, int label) {
    if (label != kTargetInImage) return;
    sum_mm += (image_.probe_from_image() * Eigen::Vector3d(c, r, 0)).head<2>();
    ++marked;
  });
  ASSERT_GT(marked, 50);
  EXPECT_LT((sum_mm / marked - seen_mm.head<2>()).norm(), 0.6);
}

TEST_F(ImageLabelsTest, WithoutTheProbeNothingIsLabelled) {
  Snapshot unseen = At({0.0, 0.0, 20.0}, Eigen::Vector3d::UnitZ());
  unseen.probe_valid = false;
  const ImageTruth truth = Truth(unseen);
  ForEachPixel(truth, [](int, int, int label) { EXPECT_EQ(label, kBeyondImage); });
  EXPECT_FALSE(truth.tip_in_image);
}

TEST_F(ImageLabelsTest, DepthIsTheDistanceFromTheFace) {
  Truth({.probe_valid = true, .ct_from_probe = LabelledPose()});
  for (int r = 0; r < image_.height_px; r += 7) {
    const float depth_mm =
        depth_mm_[static_cast<std::size_t>(r) * static_cast<std::size_t>(image_.width_px) +
                  static_cast<std::size_t>(image_.width_px / 2)];
    EXPECT_NEAR(depth_mm, PlaceMm(image_.width_px / 2, r).z(), 1e-4);
  }
}

TEST_F(ImageLabelsTest, RefusesALabelThatHasAnotherMeaning) {
  auto labels = std::make_shared<volume::LabelMap>(*scene_.labels);
  labels->voxels[5] = 251;
  EXPECT_THAT([&] { ImageLabeller(scene_, labels, {}); },
              ThrowsMessage<InputError>(HasSubstr("label 251; from 250 on")));
  EXPECT_THAT([&] { ImageLabeller(scene_, nullptr, {}); },
              ThrowsMessage<InputError>(HasSubstr("no label map")));
}

}  // namespace
}  // namespace acus::simulation
