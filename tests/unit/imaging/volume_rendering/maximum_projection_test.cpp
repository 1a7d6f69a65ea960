#include "acus/imaging/volume_rendering/maximum_projection.h"

#include <gmock/gmock.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/imaging/volume_rendering/ray_tile.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::Blob;
using testing_support::CoveredPart;
using testing_support::FieldOf;

RaySettings MaximumIn(const HuWindow& window) {
  RaySettings out;
  out.projection = Projection::kMaximum;
  out.window = window;
  return out;
}

/// Seen along y: two plates across a body of 0 HU, the brighter one behind.
constexpr float kFrontHu = 200.0F;
constexpr float kBackHu = 800.0F;
constexpr double kEyeYMm = -300.0;
constexpr double kBackFaceMm = 24.0;
struct Plates {
  std::shared_ptr<volume::CtVolume> ct;
  TransferFunction shown = ShownIn(kWindow);
  std::optional<VisibleBlocks> blocks;
  HiddenCells hidden;
  VolumeScene scene;
  static constexpr HuWindow kWindow{0.0, 1000.0};

  Plates() {
    volume::Geometry grid;
    grid.size.setConstant(41);
    grid.spacing_mm.setConstant(2.0);
    grid.origin_mm.setConstant(-40.0);
    ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{0});
    for (int k = 0; k < 41; ++k) {
      for (int i = 0; i < 41; ++i) {
        for (int j = 8; j <= 10; ++j) ct->At(i, j, k) = static_cast<std::int16_t>(kFrontHu);
        for (int j = 32; j <= 36; ++j) ct->At(i, j, k) = static_cast<std::int16_t>(kBackHu);
      }
    }
    blocks.emplace(*ct, shown, nullptr);
    blocks->Update(nullptr, 1.0);
    hidden = HiddenCells(*ct, shown);
    scene.ct = ct.get();
    scene.blocks = &*blocks;
    scene.hidden = &hidden;
  }

  static Eigen::Vector3d Eye() { return {0.3, kEyeYMm, -0.2}; }

  /// The ray along y, by itself.
  RayColour Ray(std::span<const Fragment> fragments, double tool_shine) const {
    RaySettings settings = MaximumIn(kWindow);
    settings.tool_shine = tool_shine;
    return RayCaster(scene, settings, Eye()).Cast(Eigen::Vector3d::UnitY(), fragments);
  }

  /// The same in a tile.
  RayColour RayOfTile(std::span<const Fragment> fragments, double tool_shine) const {
    RaySettings settings = MaximumIn(kWindow);
    settings.tool_shine = tool_shine;
    Camera camera = LookAt(
        {.eye_in_ct_mm = Eye(), .focus_in_ct_mm = Eye() + Eigen::Vector3d::UnitY()}, {17, 17});
    std::vector<RayColour> out(1);
    const std::span<const Fragment> of_pixel[] = {fragments};
    TileCaster(scene, settings, camera).Cast({8, 8, 1, 1}, of_pixel, 0.0F, out);
    return out[0];
  }
};

Fragment FragmentAt(double y_mm, float opacity, bool is_tool = false) {
  return {static_cast<float>(y_mm - kEyeYMm), opacity, Eigen::Array3f(0.5F, 0.1F, 0.2F), is_tool};
}

struct ExpectedColour {
  float of_projection = 0.0F;  ///< Weight of white.
  float of_fragment = 0.0F;
  double tool_shine = 0.0;
};
void ExpectRayColour(const std::vector<Fragment>& fragments, const ExpectedColour& expected) {
  const Plates plates;
  for (const bool in_tile : {false, true}) {
    const RayColour seen = in_tile ? plates.RayOfTile(fragments, expected.tool_shine)
                                   : plates.Ray(fragments, expected.tool_shine);
    for (int c = 0; c < 3; ++c) {
      const float of_fragment = fragments.empty() ? 0.0F : fragments.back().colour[c];
      EXPECT_NEAR(seen.colour[c], expected.of_projection + expected.of_fragment * of_fragment, 1e-5)
          << in_tile << c;
    }
    EXPECT_NEAR(seen.opacity, expected.of_projection + expected.of_fragment, 1e-5) << in_tile;
  }
}

TEST(MaximumProjection, ARayIsAsBrightAsTheLargestValueInTheWindow) {
  ExpectRayColour({}, {.of_projection = 0.8F});
}

TEST(MaximumProjection, BehindAnOpaqueSurfaceNothingCounts) {
  ExpectRayColour({FragmentAt(0.0, 1.0F)}, {.of_projection = 0.2F, .of_fragment = 0.8F});
  ExpectRayColour({FragmentAt(-39.0, 1.0F)}, {.of_projection = 0.0F, .of_fragment = 1.0F});
  ExpectRayColour({FragmentAt(39.0, 1.0F)}, {.of_projection = 0.8F, .of_fragment = 0.2F});
}

// The plate's flank rises from 0 HU to 800 over the 2 mm before its face: samples lie at whole mm,
// and that beyond the surface would be at 400 HU.
TEST(MaximumProjection, TheSampleBehindAnOpaqueSurfaceDoesNotCountEither) {
  const double flank_mm = kBackFaceMm - 2.0;
  ExpectRayColour({FragmentAt(flank_mm + 0.9, 1.0F)}, {.of_projection = 0.2F, .of_fragment = 0.8F});
  ExpectRayColour({FragmentAt(flank_mm + 1.1, 1.0F)}, {.of_projection = 0.4F, .of_fragment = 0.6F});
}

TEST(MaximumProjection, ATransparentSurfaceLiesInFrontWhereverItIs) {
  for (const double y_mm : {-39.0, 0.0, 39.0}) {
    ExpectRayColour({FragmentAt(y_mm, 0.25F)},
                    {.of_projection = 0.75F * 0.8F, .of_fragment = 0.25F});
  }
}

TEST(MaximumProjection, AToolShinesThrough) {
  ExpectRayColour(
      {FragmentAt(39.0, 1.0F, true)},
      {.of_projection = 0.8F * 0.7F, .of_fragment = 0.2F * 0.7F + 0.3F, .tool_shine = 0.5});
  // In front of all that is bright, it is seen as it is.
  ExpectRayColour({FragmentAt(0.0, 1.0F, true)},
                  {.of_projection = 0.2F, .of_fragment = 0.8F, .tool_shine = 0.5});
}

TEST(MaximumProjection, WhatIsCutAwayDoesNotCount) {
  Plates plates;
  const auto bright = [&](const CutPlane& cut) {
    plates.scene.cuts = {&cut, 1};
    return plates.Ray({}, 0.0).opacity;
  };
  const auto at = [](double y_mm) { return Eigen::Vector3d(0.0, y_mm, 0.0); };
  // What lies on a plane's positive side is cut away.
  const Eigen::Vector3d back = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d front = -back;
  EXPECT_FLOAT_EQ(bright(CutPlane(back, at(0.0))), 1e-3F * kFrontHu);
  EXPECT_FLOAT_EQ(bright(CutPlane(front, at(0.0))), 1e-3F * kBackHu);
  // No more than a flank: up to the last sample, and from the first one, that is left.
  const double flank_mm = kBackFaceMm - 2.0;
  EXPECT_FLOAT_EQ(bright(CutPlane(back, at(flank_mm + 0.9))), 1e-3F * kFrontHu);
  EXPECT_FLOAT_EQ(bright(CutPlane(back, at(flank_mm + 1.1))), 0.5e-3F * kBackHu);
  const double end_mm = kBackFaceMm + 10.0;  // From 800 HU to 0 over 2 mm.
  EXPECT_FLOAT_EQ(bright(CutPlane(front, at(end_mm - 1.1))), 0.5e-3F * kBackHu);
  EXPECT_NEAR(bright(CutPlane(front, at(end_mm - 0.9))), 0.0F, 1e-6F);
}

// Against every sample of every block, also where values of voxels lie at the window's low end.
TEST(MaximumProjection, SkippingChangesNoBit) {
  const auto ct = testing_support::TrunkCt(96);
  const Eigen::Vector3d eye(-300.0, -700.0, 250.0);
  const TransferFunction everything = ShownIn({TransferFunction::kLowestHu, 3071.0});
  VisibleBlocks all_blocks(*ct, everything, nullptr);
  all_blocks.Update(nullptr, 1.0);
  for (const HuWindow& window : {HuWindow{100.0, 1000.0}, HuWindow{50.0, 60.0},
                                 HuWindow{705.0, 711.0}, HuWindow{-1000.0, 0.0}}) {
    const TransferFunction shown = ShownIn(window);
    VisibleBlocks blocks(*ct, shown, nullptr);
    blocks.Update(nullptr, 1.0);
    const HiddenCells hidden(*ct, shown);
    VolumeScene scene;
    scene.ct = ct.get();
    scene.blocks = &all_blocks;
    const RayCaster plain(scene, MaximumIn(window), eye);
    scene.blocks = &blocks;
    scene.hidden = &hidden;
    const RayCaster skipping(scene, MaximumIn(window), eye);
    int seen = 0;
    for (int row = -20; row < 20; ++row) {
      for (int column = -20; column < 20; ++column) {
        const auto ray = [&](double x, double y) {
          return Eigen::Vector3d(
              (Eigen::Vector3d(300.0, 700.0, -250.0) + 10.0 * Eigen::Vector3d(x, 0.0, y))
                  .normalized());
        };
        const Eigen::Vector3d rim[] = {ray(column - 0.5, row - 0.5), ray(column + 0.5, row - 0.5),
                                       ray(column - 0.5, row + 0.5), ray(column + 0.5, row + 0.5)};
        const float empty_mm = skipping.EmptyUntilMm(ray(column, row), rim);
        for (const double off : {-0.45, 0.0, 0.3}) {
          const Eigen::Vector3d direction = ray(column + off, row - off);
          const RayColour a = plain.Cast(direction, {});
          const RayColour b = skipping.Cast(direction, {}, empty_mm);
          ASSERT_TRUE((a.colour == b.colour).all());
          ASSERT_EQ(a.opacity, b.opacity);
          seen += a.opacity > 0.0F;
        }
      }
    }
    EXPECT_GT(seen, 100) << window.low_hu;
  }
}

constexpr double kMaximumRadiusMm = 20.0;
const Eigen::Vector3d kMaximumCentreMm{12.0, -8.0, 15.0};

/// A ball of 300 HU in a black image.
PatientView BallView(const HuWindow& window, const breathing::MotionField* field = nullptr) {
  ViewSettings settings;
  settings.rays = MaximumIn(window);
  settings.background_top = settings.background_bottom = Eigen::Array3f::Zero();
  return PatientView({.ct = testing_support::BallCt(kMaximumCentreMm, kMaximumRadiusMm),
                      .layers = {},
                      .surfaces = {},
                      .field = field},
                     settings);
}

Camera MaximumCamera() {
  return LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}}, {256, 256});
}

ViewImage RenderMaximum(PatientView& view, const ViewMoment& moment = {}, int num_threads = 1) {
  ViewImage image;
  view.Render(MaximumCamera(), moment, image, num_threads);
  return image;
}

TEST(MaximumProjection, ABallIsAsBrightAsItsHuAndAsLarge) {
  PatientView view = BallView({100.0, 500.0});
  const ViewImage image = RenderMaximum(view);
  const Eigen::Vector2d middle_px = MaximumCamera().ProjectPx(kMaximumCentreMm);
  int inside = 0;
  for (int row = 0; row < 256; ++row) {
    for (int column = 0; column < 256; ++column) {
      const auto pixel = static_cast<std::size_t>(256 * row + column);
      const double px = (Eigen::Vector2d(column, row) - middle_px).norm();
      EXPECT_LE(image.coverage[pixel], 128);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(image.colour.rgb[3 * pixel + c], image.coverage[pixel]);
      }
      if (px > 10.0) continue;
      EXPECT_EQ(image.coverage[pixel], 128);  // (300 - 100) / (500 - 100), rounded.
      ++inside;
    }
  }
  EXPECT_GT(inside, 300);
  // -335 HU is at the radius.
  PatientView solid = BallView({-336.0, -334.0});
  const double distance_mm = (MaximumCamera().EyeInCtMm() - kMaximumCentreMm).norm();
  const double true_px =
      2.0 * MaximumCamera().focal_px[0] * std::tan(std::asin(kMaximumRadiusMm / distance_mm));
  const Blob blob = CoveredPart(RenderMaximum(solid));
  EXPECT_LT((blob.middle_px - middle_px).norm(), 0.3);
  EXPECT_NEAR(blob.diameter_px, true_px, 1.0);
}

TEST(MaximumProjection, BreathMovesTheBallByTheProjectedDisplacement) {
  const Eigen::Vector3d shift_mm(6.0, -9.0, -17.0);
  const auto field = FieldOf([&](const Eigen::Vector3d&) { return shift_mm; });
  const auto motion = testing_support::At(field, 1.0);
  PatientView view = BallView({-336.0, -334.0}, &field);
  const Blob at_rest = CoveredPart(RenderMaximum(view));
  const Blob moved = CoveredPart(RenderMaximum(view, {.motion = &motion}));
  const Eigen::Vector2d middle_px = MaximumCamera().ProjectPx(kMaximumCentreMm + shift_mm);
  EXPECT_LT((moved.middle_px - middle_px).norm(), 0.3);
  EXPECT_GT((moved.middle_px - at_rest.middle_px).norm(), 8.0);
}

TEST(MaximumProjection, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const auto field = FieldOf(testing_support::DiaphragmMm);
  const auto motion = testing_support::At(field, 0.7);
  PatientView view = BallView({100.0, 500.0}, &field);
  ViewMoment moment{.motion = &motion};
  moment.needle = image::NeedleInImage{kMaximumCentreMm, Eigen::Vector3d::UnitX(), 90.0, 0.5};
  const ViewImage first = RenderMaximum(view, moment);
  RenderMaximum(view);  // Something else between.
  for (const int num_threads : {1, 2, 5}) {
    const ViewImage again = RenderMaximum(view, moment, num_threads);
    EXPECT_EQ(again.colour.rgb, first.colour.rgb);
    EXPECT_EQ(again.coverage, first.coverage);
  }
}

TEST(MaximumProjection, OfLessThanTheWindowNothingShows) {
  PatientView view = BallView({301.0, 500.0});
  EXPECT_THAT(RenderMaximum(view).coverage, ::testing::Each(0));
}

TEST(MaximumProjection, RefusesAWindowThatDoesNotRiseAndAPatientWithoutACt) {
  const auto in = [](double low_hu, double high_hu) {
    return [=] { BallView({low_hu, high_hu}); };
  };
  const auto refused = [](const char* why) { return ThrowsMessage<InputError>(HasSubstr(why)); };
  EXPECT_THAT(in(500.0, 100.0), refused("from 500 to 100 HU"));
  EXPECT_THAT(in(100.0, 100.0), refused("below the high end"));
  EXPECT_THAT(in(-1025.0, 100.0), refused("-1024 to 3071"));
  EXPECT_THAT(in(100.0, 3072.0), refused("-1024 to 3071"));
  EXPECT_THAT(in(std::numeric_limits<double>::quiet_NaN(), 100.0), refused("window"));
  const auto without_ct = [] {
    PatientInView patient;
    patient.surfaces = {{"ball", testing_support::BallSurface(kMaximumCentreMm, kMaximumRadiusMm)}};
    PatientView(patient, {.rays = MaximumIn({})});
  };
  EXPECT_THAT(without_ct, refused("needs a CT"));
}

}  // namespace
}  // namespace acus::volume_rendering
