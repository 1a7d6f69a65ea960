#include "acus/imaging/volume_rendering/patient_view.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::At;
using testing_support::BallCt;
using testing_support::BallSurface;
using testing_support::Blob;
using testing_support::CoveredPart;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;

const Eigen::Vector3d kCentreMm{12.0, -8.0, 15.0};
constexpr double kRadiusMm = 20.0;

Camera SideCamera() {
  return LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}}, {256, 256});
}

/// What a ball is in an image: an ellipse. Its middle and area by rays against the ball.
Blob TrueBlob(const Camera& camera, const Eigen::Vector3d& centre_mm) {
  ViewImage image;
  image.colour.Resize(camera.width_px, camera.height_px);
  image.coverage.resize(image.colour.rgb.size() / 3);
  const Eigen::Vector3d to_centre = centre_mm - camera.EyeInCtMm();
  for (int row = 0; row < camera.height_px; ++row) {
    for (int column = 0; column < camera.width_px; ++column) {
      const Eigen::Vector3d ray = camera.DirectionInCt({column, row}).normalized();
      const double miss_mm = (to_centre - to_centre.dot(ray) * ray).norm();
      image.coverage[static_cast<std::size_t>(row * camera.width_px + column)] =
          miss_mm < kRadiusMm ? 255 : 0;
    }
  }
  return CoveredPart(image);
}

void ExpectSame(const Blob& seen, const Blob& truth) {
  EXPECT_LT((seen.middle_px - truth.middle_px).norm(), 0.3);
  EXPECT_NEAR(seen.diameter_px, truth.diameter_px, 1.0);
}

PatientInView BallPatient(const breathing::MotionField* field = nullptr) {
  return {.ct = BallCt(kCentreMm, kRadiusMm),
          .layers = {{"skin", 1.0}},
          .surfaces = {},
          .field = field};
}
PatientInView SurfacePatient(const breathing::MotionField* field = nullptr) {
  return {.ct = nullptr,
          .layers = {},
          .surfaces = {{"ball", BallSurface(kCentreMm, kRadiusMm)}},
          .field = field};
}

ViewImage Render(PatientView& view, const ViewMoment& moment = {}, int num_threads = 1) {
  ViewImage image;
  view.Render(SideCamera(), moment, image, num_threads);
  return image;
}

TEST(PatientView, ABallIsWhereItProjectsAndAsLarge) {
  const Blob truth = TrueBlob(SideCamera(), kCentreMm);
  PatientView volume(BallPatient(), {});
  PatientView surface(SurfacePatient(), {});
  ExpectSame(CoveredPart(Render(volume)), truth);
  ExpectSame(CoveredPart(Render(surface)), truth);
}

TEST(PatientView, BreathMovesTheBallByTheProjectedDisplacement) {
  const Eigen::Vector3d shift_mm(6.0, -9.0, -17.0);
  const auto field = FieldOf([&](const Eigen::Vector3d&) { return shift_mm; });
  const auto motion = At(field, 1.0);
  const Blob truth = TrueBlob(SideCamera(), kCentreMm + shift_mm);
  PatientView volume(BallPatient(&field), {});
  PatientView surface(SurfacePatient(&field), {});
  ExpectSame(CoveredPart(Render(volume, {.motion = &motion})), truth);
  ExpectSame(CoveredPart(Render(surface, {.motion = &motion})), truth);
}

TEST(PatientView, VolumeAndSurfaceMoveAlikeInAFieldThatBendsThem) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 1.0);
  PatientView volume(BallPatient(&field), {});
  PatientView surface(SurfacePatient(&field), {});
  const Blob at_rest = CoveredPart(Render(surface));
  const Blob by_volume = CoveredPart(Render(volume, {.motion = &motion}));
  const Blob by_surface = CoveredPart(Render(surface, {.motion = &motion}));
  EXPECT_GT((by_surface.middle_px - at_rest.middle_px).norm(), 8.0);
  ExpectSame(by_volume, by_surface);
}

TEST(PatientView, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 0.7);
  PatientInView patient = BallPatient(&field);
  patient.surfaces = {{"veil", BallSurface(kCentreMm, 1.3 * kRadiusMm), {0.2F, 0.5F, 0.9F}, 0.3}};
  ViewMoment moment{.motion = &motion};
  moment.needle = image::NeedleInImage{kCentreMm, Eigen::Vector3d::UnitX(), 90.0, 0.5};
  PatientView view(patient, {});
  const ViewImage first = Render(view, moment);
  Render(view);  // Something else between.
  const auto more = At(field, 1.4);
  Render(view, {.motion = &more});
  for (const int num_threads : {1, 2, 5}) {
    const ViewImage again = Render(view, moment, num_threads);
    EXPECT_EQ(again.colour.rgb, first.colour.rgb);
    EXPECT_EQ(again.coverage, first.coverage);
  }
}

TEST(PatientView, HeldStillIsAsWithoutBreath) {
  const auto field = FieldOf(DiaphragmMm);
  const breathing::MotionMap still(field, {});
  PatientView breathing(BallPatient(&field), {});
  PatientView never(BallPatient(), {});
  EXPECT_EQ(Render(breathing, {.motion = &still}).colour.rgb, Render(never).colour.rgb);
}

TEST(PatientView, OpaqueSurfacesHideAndTransparentOnesLetThrough) {
  PatientInView patient = SurfacePatient();
  patient.surfaces[0].colour = {1.0F, 0.0F, 0.0F};
  patient.surfaces.push_back(
      {"shell", BallSurface(kCentreMm, 2.0 * kRadiusMm), {0.0F, 0.0F, 1.0F}, 1.0});
  const Eigen::Vector2d middle_px = SideCamera().ProjectPx(kCentreMm);
  const auto at =
      static_cast<std::size_t>(3 * (256 * std::lround(middle_px[1]) + std::lround(middle_px[0])));
  PatientView hidden(patient, {});
  const ViewImage shell = Render(hidden);
  EXPECT_GT(shell.colour.rgb[at + 2], 4 * shell.colour.rgb[at]);
  patient.surfaces[1].opacity = 0.2;
  PatientView through(patient, {});
  const ViewImage seen = Render(through);
  EXPECT_GT(seen.colour.rgb[at], 2 * seen.colour.rgb[at + 2]);
}

TEST(PatientView, TheNeedleIsSeenThroughTissueOnlyIfItShines) {
  ViewMoment moment;
  moment.needle = image::NeedleInImage{kCentreMm, Eigen::Vector3d::UnitX(), 15.0, 1.0};
  ViewSettings dark;
  dark.rays.tool_shine = 0.0;
  PatientView plain(BallPatient(), dark);
  PatientView shining(BallPatient(), {});
  // The middle of the shaft.
  const Eigen::Vector2d px = SideCamera().ProjectPx(kCentreMm - 8.0 * Eigen::Vector3d::UnitX());
  const auto at = static_cast<std::size_t>(3 * (256 * std::lround(px[1]) + std::lround(px[0])));
  // Rays end where 0.4 % of the light gets through: a grey level.
  EXPECT_NEAR(Render(plain, moment).colour.rgb[at + 2], Render(plain).colour.rgb[at + 2], 1);
  EXPECT_GT(Render(shining, moment).colour.rgb[at + 2], Render(shining).colour.rgb[at + 2] + 10);
}

TEST(PatientView, AnArrowIsDrawnFromItsBeginningToItsEnd) {
  PatientInView far = SurfacePatient();
  PatientView view(far, {});
  const ViewImage without = Render(view);
  const Eigen::Vector3d from_mm = kCentreMm + 2.0 * kRadiusMm * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d to_mm = from_mm + 30.0 * Eigen::Vector3d::UnitZ();
  const ViewImage with = Render(view, {.arrow = Arrow{from_mm, to_mm}});
  const auto is_red_at = [&](const Eigen::Vector3d& place_mm) {
    const Eigen::Vector2d px = SideCamera().ProjectPx(place_mm);
    const auto at = static_cast<std::size_t>(3 * (256 * std::lround(px[1]) + std::lround(px[0])));
    return with.colour.rgb[at] > 2 * with.colour.rgb[at + 2];
  };
  EXPECT_TRUE(is_red_at(from_mm + 3.0 * Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(is_red_at(to_mm - 4.0 * Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(is_red_at(to_mm + 4.0 * Eigen::Vector3d::UnitZ()));
  const Arrow none[] = {{from_mm, from_mm},
                        {from_mm, {std::nan(""), 0, 0}},
                        {from_mm, {std::numeric_limits<double>::infinity(), 0, 0}}};
  for (const Arrow& arrow : none) {
    EXPECT_EQ(Render(view, {.arrow = arrow}).colour.rgb, without.colour.rgb);
  }
}

TEST(PatientView, AToolThrowsItsShadowOnTheSkin) {
  const Camera camera = SideCamera();
  ViewSettings no_shadows;
  no_shadows.tool_shadows = false;
  PatientView lit(SurfacePatient(), no_shadows);
  PatientView shaded(SurfacePatient(), {});
  // A thick needle between the lamp and the ball, above it.
  const Eigen::Vector3d to_lamp = camera.camera_from_ct.linear().transpose() *
                                  Eigen::Vector3d(-0.40, -0.55, -0.75).normalized();
  ViewMoment moment;
  moment.needle = image::NeedleInImage{kCentreMm + 40.0 * to_lamp + Eigen::Vector3d(5, 0, 0),
                                       Eigen::Vector3d::UnitX(), 10.0, 3.0};
  const Eigen::Vector2d px = camera.ProjectPx(kCentreMm + kRadiusMm * to_lamp);
  const auto at = static_cast<std::size_t>(3 * (256 * std::lround(px[1]) + std::lround(px[0])));
  EXPECT_LT(1.4 * Render(shaded, moment).colour.rgb[at], Render(lit, moment).colour.rgb[at]);
}

TEST(PatientView, RefusesWhatCannotBeShown) {
  const auto with_settings = [](auto change) {
    return [change] {
      ViewSettings settings;
      change(settings);
      PatientView(SurfacePatient(), settings);
    };
  };
  EXPECT_THAT(with_settings([](auto& s) { s.rays.step_mm = 0.0; }),
              ThrowsMessage<InputError>(HasSubstr("0.05 to 20 mm")));
  EXPECT_THAT(with_settings([](auto& s) { s.rays.step_mm = 21.0; }),
              ThrowsMessage<InputError>(HasSubstr("21 mm apart")));
  EXPECT_THAT(with_settings([](auto& s) { s.rays.warp.max_iterations = 0; }),
              ThrowsMessage<InputError>(HasSubstr("1 to 1000")));
  EXPECT_THAT(with_settings([](auto& s) { s.rays.warp.tolerance_mm = std::nan(""); }),
              ThrowsMessage<InputError>(HasSubstr("tolerance")));
  EXPECT_THAT(with_settings([](auto& s) { s.rays.tool_shine = 1.1; }),
              ThrowsMessage<InputError>(HasSubstr("shine")));
  EXPECT_THAT(with_settings([](auto& s) { s.supersampling = 3; }),
              ThrowsMessage<InputError>(HasSubstr("1, 2 and 4")));
  EXPECT_THAT([] { PatientView({}, {}); }, ThrowsMessage<InputError>(HasSubstr("nothing to show")));
  const auto layers_without_ct = [] {
    PatientInView patient;
    patient.layers.push_back({"bone", 1.0});
    PatientView(patient, {});
  };
  EXPECT_THAT(layers_without_ct, ThrowsMessage<InputError>(HasSubstr("need a CT")));
  EXPECT_THAT(
      [] {
        PatientInView patient = SurfacePatient();
        patient.surfaces[0].opacity = 1.5;
        PatientView(patient, {});
      },
      ThrowsMessage<InputError>(HasSubstr("\"ball\"")));
  EXPECT_THAT(
      [] {
        PatientInView patient = SurfacePatient();
        patient.surfaces[0].surface.triangles(0, 0) = 1'000'000;
        PatientView(patient, {});
      },
      ThrowsMessage<InputError>(HasSubstr("1000000")));
}

TEST(PatientView, RefusesAMomentThatIsNone) {
  const auto field = FieldOf(DiaphragmMm, 8);
  const auto other = FieldOf(DiaphragmMm, 8);
  const auto motion = At(other, 1.0);
  PatientView view(SurfacePatient(&field), {});
  EXPECT_THAT([&] { Render(view, {.motion = &motion}); },
              ThrowsMessage<InputError>(HasSubstr("another field")));
  ViewMoment moment;
  moment.needle = image::NeedleInImage{Eigen::Vector3d::Constant(std::nan("")),
                                       Eigen::Vector3d::UnitX(), 90.0, 0.5};
  EXPECT_THAT([&] { Render(view, moment); }, ThrowsMessage<InputError>(HasSubstr("not finite")));
}

/// Works for some images, then fails as a card does that is reset.
class FailingDevice final : public RayDevice {
 public:
  explicit FailingDevice(int num_good) : left_(num_good) {}
  std::string name() const override { return "stand-in"; }
  void Load(const VolumeScene&, const breathing::MotionField*) override {}
  void Render(const VolumeScene&, const DeviceImage&, std::span<std::uint8_t> rgb,
              std::span<std::uint8_t> coverage) override {
    ACUS_REQUIRE(left_-- > 0, "the card was reset");
    std::ranges::fill(rgb, std::uint8_t{255});
    std::ranges::fill(coverage, std::uint8_t{255});
  }
  std::uint64_t bytes_sent() const override { return 0; }

 private:
  int left_;
};

TEST(PatientView, TheProcessorGoesOnWhereADeviceFails) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 0.7);
  const ViewMoment moment{.motion = &motion};
  PatientView without(BallPatient(&field), {});
  const ViewImage expected = Render(without, moment);
  PatientView view(BallPatient(&field), {});
  view.UseDevice(std::make_unique<FailingDevice>(1));
  const ViewImage first = Render(view, moment);
  EXPECT_THAT(first.colour.rgb, ::testing::Each(255));
  EXPECT_EQ(view.device_trouble(), "");
  for (int n = 0; n < 2; ++n) {
    const ViewImage image = Render(view, moment);
    EXPECT_EQ(image.colour.rgb, expected.colour.rgb);
    EXPECT_EQ(image.coverage, expected.coverage);
    EXPECT_EQ(view.device_trouble(), "the card was reset");
  }
}

}  // namespace
}  // namespace acus::volume_rendering
