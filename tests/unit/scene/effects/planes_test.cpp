#include "acus/scene/effects/planes/planes.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/scene/effects/planes/plane_poses.h"
#include "acus/scene/effects/ports.h"
#include "support/synthetic_ct.h"

namespace acus::effects {
namespace {

using nlohmann::json;

TEST(PlanePoses, SidesOfThePatientAreWhereRadiologistsHaveThem) {
  const Eigen::Vector3d through(10.0, -4.0, 33.0);
  const Eigen::Vector3d left = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d back = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d head = Eigen::Vector3d::UnitZ();
  const auto expect = [&](PatientPlane plane, const Eigen::Vector3d& right,
                          const Eigen::Vector3d& down) {
    const Eigen::Isometry3d pose = PoseOf(plane, through, Eigen::Vector3d::Zero());
    EXPECT_EQ(pose.translation(), through);
    EXPECT_EQ(Eigen::Vector3d(pose.linear().col(0)), right) << TitleOf(plane);
    EXPECT_EQ(Eigen::Vector3d(pose.linear().col(1)), down) << TitleOf(plane);
    EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-12);
  };
  expect(PatientPlane::kAxial, left, back);
  expect(PatientPlane::kCoronal, left, -head);
  expect(PatientPlane::kSagittal, back, -head);
  expect(PatientPlane::kOblique, left, back);
}

TEST(PlanePoses, TheObliquePlaneHoldsTheNeedleWhichPointsDown) {
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(0.3, 0.8, -0.5), Eigen::Vector3d(0, 0, 1),
                                      Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(1e-5, 0, -1)}) {
    const Eigen::Vector3d unit = axis.normalized();
    const Eigen::Isometry3d pose = PoseOf(PatientPlane::kOblique, Eigen::Vector3d::Zero(), unit);
    EXPECT_LT((pose.linear().col(1) - unit).norm(), 1e-9);
    EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-9);
    EXPECT_LT((pose.linear().transpose() * pose.linear() - Eigen::Matrix3d::Identity()).norm(),
              1e-9);
  }
  EXPECT_THROW(PatientPlaneOf("frontal"), InputError);
}

/// A block of 900 HU around one place, in soft tissue.
volume::CtVolume BlockCt(const Eigen::Vector3d& at) {
  return testing_support::SyntheticCt({80, 80, 80}, 1.0, [&](double x, double y, double z) {
    return (Eigen::Vector3d(x, y, z) - at).cwiseAbs().maxCoeff() < 2.6 ? 900.0 : 40.0;
  });
}

class Shifted : public slicing::RestMap {
 public:
  explicit Shifted(const Eigen::Vector3d& by) : by_(by) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place,
                             const Eigen::Vector3d&) const noexcept override {
    return place - by_;
  }
  double SpacingMm() const noexcept override { return 5.0; }

 private:
  Eigen::Vector3d by_;
};

class PlanesTest : public ::testing::Test {
 protected:
  PlanesTest() {
    settings_ = {{"planes", json::array({"axial", "coronal", "sagittal", "oblique"})},
                 {"width_px", 64},
                 {"height_px", 48},
                 {"mm_per_px", 1.0},
                 {"thickness_mm", 0.0},
                 {"slab", "mean"},
                 {"window", {{"centre_hu", 40}, {"width_hu", 400}}},
                 {"needle", false},
                 {"rate_hz", 10}};
    needle_.tip_in_ct_mm = {41.0, 38.0, 42.0};
    needle_.axis_in_ct = Eigen::Vector3d::UnitY();
    needle_.length_mm = 100.0;
    needle_.radius_mm = 0.5;
    ports_.Set(ports::kCt, &ct_);
    ports_.Set(ports::kRestMap, static_cast<const slicing::RestMap*>(nullptr));
  }
  image::GrayImage Image(const slicing::RestMap* rest = nullptr) {
    RunContext context;
    const auto loaded = Planes().Load(settings_, ports_, context);
    const auto stage = loaded->NewImageStage(ports_, context);
    ImageMoment moment;
    moment.needle = &needle_;
    ports_.Set(ports::kRestMap, rest);
    EffectPixels out;
    EXPECT_EQ(stage->Render(moment, ports_, out), Activity::kActive);
    moment.changes = {.needle = false, .probe = true, .breath = false, .tissue = false};
    EXPECT_EQ(stage->Render(moment, ports_, out), Activity::kUnchanged);
    return out.gray;
  }
  /// White pixels of plane n: their mean column and row, from the plane's middle.
  static Eigen::Vector2d White(const image::GrayImage& image, int n, int columns) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
    const int left = 64 * (n % columns);
    const int top = 48 * (n / columns);
    for (int r = 10; r < 38; ++r) {
      for (int c = 10; c < 54; ++c) {
        if (image.At(left + c, top + r) < 250) continue;
        sum += Eigen::Vector2d(c - 31.5, r - 23.5);
        ++count;
      }
    }
    EXPECT_GT(count, 0) << "plane " << n;
    return sum / std::max(1, count);
  }

  volume::CtVolume ct_ = BlockCt({48.0, 38.0, 42.0});
  json settings_;
  image::NeedleInImage needle_;
  PortValues ports_;
};

TEST_F(PlanesTest, GoThroughTheTip) {
  const image::GrayImage image = Image();
  ASSERT_EQ(image.width, 128);
  ASSERT_EQ(image.height, 96);
  // The block is 7 mm to the left of the tip.
  EXPECT_LT((White(image, 0, 2) - Eigen::Vector2d(7.0, 0.0)).norm(), 0.6) << "axial";
  EXPECT_LT((White(image, 1, 2) - Eigen::Vector2d(7.0, 0.0)).norm(), 0.6) << "coronal";
  EXPECT_LT((White(image, 3, 2) - Eigen::Vector2d(7.0, 0.0)).norm(), 0.6) << "oblique";
  for (int r = 10; r < 38; ++r) {
    for (int c = 10; c < 54; ++c) EXPECT_LT(image.At(c, 48 + r), 140) << "sagittal: beside it";
  }
}

TEST_F(PlanesTest, FollowBreathAndTools) {
  const Shifted rest({-3.0, 5.0, 0.0});
  const image::GrayImage image = Image(&rest);
  EXPECT_LT((White(image, 0, 2) - Eigen::Vector2d(4.0, 5.0)).norm(), 0.6);
}

TEST_F(PlanesTest, ASlabOfTheMaximumShowsWhatASliceBesideItDoesNot) {
  settings_["planes"] = json::array({"sagittal"});
  settings_["thickness_mm"] = 20.0;
  settings_["slab"] = "maximum";
  EXPECT_LT(White(Image(), 0, 1).norm(), 0.6);
  settings_["slab"] = "mean";
  const image::GrayImage mean = Image();
  // 5 of 20 mm are 900 HU: 255 is the mean's 255 HU, above the window's white.
  EXPECT_EQ(mean.At(31, 23), 255);
  settings_["thickness_mm"] = 100.0;
  EXPECT_NEAR(Image().At(31, 23), 255.0 * (200.0 + 860.0 * 5.0 / 100.0 - 1064.0 * 0.19) / 400.0,
              14.0);
}

TEST_F(PlanesTest, AFixedPlaceStaysAndThePlaneAloneHasItsOwnSize) {
  settings_["planes"] = json::array({"axial"});
  settings_["centre_mm"] = json::array({40.0, 38.0, 42.0});
  const image::GrayImage image = Image();
  EXPECT_EQ(image.width, 64);
  EXPECT_LT((White(image, 0, 1) - Eigen::Vector2d(8.0, 0.0)).norm(), 0.6);
  settings_["planes"] = json::array({"axial", "axial"});
  EXPECT_THROW(Planes().Check(settings_, "scene.json"), InputError);
}

}  // namespace
}  // namespace acus::effects
