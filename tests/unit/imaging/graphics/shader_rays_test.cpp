// The image of the shader against that of the processor, on the driver that there is: without a
// graphics card Mesa's, which computes on the processor.
#include "acus/imaging/graphics/shader_rays.h"

#include <cmath>
#include <gmock/gmock.h>
#include <thread>

#include "acus/data/volume/labels.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::graphics {
namespace {

using testing_support::BallCt;
using testing_support::BallSurface;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;
using testing_support::PsnrDb;
using volume_rendering::Camera;
using volume_rendering::PatientInView;
using volume_rendering::PatientView;
using volume_rendering::PressedTissue;
using volume_rendering::ViewImage;
using volume_rendering::ViewMoment;
using volume_rendering::ViewSettings;

/// What issue and page ask for, against the full scale.
constexpr double kLeastPsnrDb = 40.0;

Camera SideCamera(int width_px = 160, int height_px = 120) {
  return volume_rendering::LookAt({.eye_in_ct_mm = {-150, -420, 180}, .focus_in_ct_mm = {0, 0, 0}},
                                  {width_px, height_px});
}

ViewImage OnProcessor(const PatientInView& patient, const ViewMoment& moment,
                      const Camera& camera = SideCamera(), const ViewSettings& settings = {}) {
  PatientView view(patient, settings);
  ViewImage image;
  view.Render(camera, moment, image, 2);
  return image;
}

ViewImage ByShader(const PatientInView& patient, const ViewMoment& moment,
                   const Camera& camera = SideCamera(), const ViewSettings& settings = {}) {
  PatientView view(patient, settings);
  view.UseDevice(MakeShaderRays(DriverKind::kAny));
  ViewImage image;
  view.Render(camera, moment, image, 2);
  EXPECT_EQ(view.device_trouble(), "");
  return image;
}

void ExpectSameImage(const ViewImage& shader, const ViewImage& processor) {
  ASSERT_EQ(shader.colour.rgb.size(), processor.colour.rgb.size());
  EXPECT_GT(PsnrDb(shader, processor), kLeastPsnrDb);
  EXPECT_GT(PsnrDb(shader.coverage, processor.coverage), kLeastPsnrDb);
  // There is something to compare.
  EXPECT_GT(*std::ranges::max_element(processor.coverage), 200);
}

void ExpectSameImage(const PatientInView& patient, const ViewMoment& moment = {}) {
  ExpectSameImage(ByShader(patient, moment), OnProcessor(patient, moment));
}

PatientInView Ball(const char* layer, const breathing::MotionField* field = nullptr) {
  return {.ct = BallCt({12.0, -8.0, 15.0}, 20.0),
          .layers = {{layer, 1.0}},
          .surfaces = {},
          .field = field};
}

PatientInView Trunk(std::vector<volume_rendering::VolumeLayer> layers,
                    const breathing::MotionField* field = nullptr) {
  return {.ct = testing_support::TrunkCt(64),
          .layers = std::move(layers),
          .surfaces = {},
          .field = field};
}

TEST(ShaderRays, GiveTheImageOfTheProcessor) {
  ExpectSameImage(Ball("skin"));
  ExpectSameImage(Ball("bone"));
  PatientInView trunk = Trunk({{"soft_tissue", 1.0}});
  ExpectSameImage(trunk);
  trunk.layers = {{"bone", 1.0}, {"skin", 0.3}};
  ExpectSameImage(trunk);
}

TEST(ShaderRays, FollowBreath) {
  const auto field = FieldOf(DiaphragmMm, 48, 3);
  breathing::MotionWeights weights;
  for (const double share : {0.8, -0.3, 0.5}) weights.Add(weights.count, share);
  const breathing::MotionMap motion(field, weights);
  ExpectSameImage(Ball("skin", &field), {.motion = &motion});
  const auto deep = testing_support::At(field, 1.6);
  ExpectSameImage(Trunk({{"bone", 1.0}}, &field), {.motion = &deep});
}

// Fields stay on the card: what was there for another moment is not mixed up with this one.
TEST(ShaderRays, KeepFieldsApartWhileKeyFramesChange) {
  const auto field = FieldOf(DiaphragmMm, 24, 12);
  PatientView view(Ball("skin", &field), {});
  view.UseDevice(MakeShaderRays(DriverKind::kAny));
  for (const int first : {0, 3, 9, 6, 0, 10}) {
    breathing::MotionWeights weights;
    weights.Add(first, 2.0);
    weights.Add(first + 1, 1.5);
    const breathing::MotionMap motion(field, weights);
    ViewImage image;
    view.Render(SideCamera(), {.motion = &motion}, image, 1);
    ExpectSameImage(image, OnProcessor(Ball("skin", &field), {.motion = &motion}));
  }
}

// Components of one field that move differently; and nothing of the breath stays when it stops.
TEST(ShaderRays, TellComponentsApartAndRestFromBreath) {
  auto field = FieldOf(DiaphragmMm, 24, 2);
  std::vector<float> aside(3 * field.nodes().num_voxels(), 0.0F);
  for (std::size_t n = 0; n < aside.size(); n += 3) aside[n] = 15.0F;
  field.SetComponent(1, aside);
  breathing::MotionWeights weights;
  weights.Add(0, 0.5);
  weights.Add(1, 1.0);
  const breathing::MotionMap motion(field, weights);
  const PatientInView patient = Ball("skin", &field);
  PatientView view(patient, {});
  view.UseDevice(MakeShaderRays(DriverKind::kAny));
  for (const ViewMoment& moment : {ViewMoment{.motion = &motion}, ViewMoment{}}) {
    ViewImage image;
    view.Render(SideCamera(), moment, image, 1);
    ExpectSameImage(image, OnProcessor(patient, moment));
  }
}

TEST(ShaderRays, MixSurfacesAndToolsIn) {
  PatientInView patient = Trunk({{"soft_tissue", 0.6}});
  patient.surfaces = {{"veil", BallSurface({0, 0, 0}, 60.0), {0.2F, 0.5F, 0.9F}, 0.3},
                      {"stone", BallSurface({30, -40, 10}, 15.0), {0.9F, 0.3F, 0.2F}, 1.0}};
  const acoustics::Probe probe = acoustics::DefaultProbe();
  ViewMoment moment;
  moment.needle = image::NeedleInImage{{0, 0, 0}, Eigen::Vector3d(0, 1, 0.2).normalized(), 220, 1};
  moment.probe.emplace();
  moment.probe->probe = &probe;
  moment.probe->ct_from_probe.translation() << 10, -130, 20;
  ExpectSameImage(patient, moment);
}

TEST(ShaderRays, ShowPressedTissueAndCuts) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = testing_support::At(field, 0.7);
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-60, -80, -50), Eigen::Vector3d(80, 60, 70));
  const PressedTissue pressed(
      box, 5.0,
      [](const Eigen::Vector3d& x, const Eigen::Vector3d&) -> Eigen::Vector3d {
        const double far_2 = (x - Eigen::Vector3d(12, -28, 15)).squaredNorm() / 200.0;
        return x - 10.0 * std::exp(-0.5 * far_2) * Eigen::Vector3d::UnitY();
      },
      2);
  ViewMoment moment{.motion = &motion};
  moment.pressed = &pressed;
  ExpectSameImage(Ball("skin", &field), moment);
  moment.cuts = {volume_rendering::CutPlane(Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, -10, 0))};
  ExpectSameImage(Ball("bone", &field), moment);
}

TEST(ShaderRays, ProjectMaxima) {
  ViewSettings settings;
  settings.rays.projection = volume_rendering::Projection::kMaximum;
  PatientInView patient = Trunk({});
  patient.surfaces = {{"veil", BallSurface({0, 0, 0}, 60.0), {0.2F, 0.5F, 0.9F}, 0.3},
                      {"stone", BallSurface({30, -40, 10}, 15.0), {0.9F, 0.3F, 0.2F}, 1.0}};
  const Camera camera = SideCamera();
  ExpectSameImage(ByShader(patient, {}, camera, settings),
                  OnProcessor(patient, {}, camera, settings));
  const ViewMoment cut{
      .cuts = {volume_rendering::CutPlane(Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, -10, 0))}};
  ExpectSameImage(ByShader(patient, cut, camera, settings),
                  OnProcessor(patient, cut, camera, settings));
  settings.rays.window = {.low_hu = -900.0, .high_hu = 200.0};
  ExpectSameImage(ByShader(patient, {}, camera, settings),
                  OnProcessor(patient, {}, camera, settings));
}

TEST(ShaderRays, ATissueHasItsOwnFunction) {
  volume::Geometry grid;
  grid.size = {40, 40, 40};
  grid.spacing_mm.setConstant(3.0);
  grid.origin_mm.setConstant(-58.5);
  const auto labels = std::make_shared<volume::LabelMap>(grid, volume::LabelOf("muscle"));
  for (int k = 12; k < 30; ++k) {
    for (int j = 10; j < 25; ++j) {
      for (int i = 8; i < 31; ++i) labels->At(i, j, k) = volume::LabelOf("liver");
    }
  }
  ExpectSameImage({.ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{60}),
                   .layers = {{"liver", 1.0}, {"muscle", 0.2}},
                   .surfaces = {},
                   .labels = labels});
}

TEST(ShaderRays, TakeAnotherSizeEachTime) {
  const PatientInView patient = Ball("skin");
  ViewSettings settings;
  settings.supersampling = 2;
  PatientView view(patient, settings);
  view.UseDevice(MakeShaderRays(DriverKind::kAny));
  for (const auto& [width, height] : {std::pair{24, 30}, {131, 67}, {16, 200}, {64, 64}}) {
    const Camera camera = SideCamera(width, height);
    ViewImage image;
    view.Render(camera, {}, image, 2);
    EXPECT_EQ(view.device_trouble(), "");
    ExpectSameImage(image, OnProcessor(patient, {}, camera, settings));
  }
}

TEST(ShaderRays, SurviveAFieldThatFoldsAndAnEmptyVolume) {
  const auto field = FieldOf(
      [](const Eigen::Vector3d& place) -> Eigen::Vector3d {
        return 60.0 * Eigen::Vector3d(std::sin(place[1] / 9.0), std::sin(place[2] / 7.0),
                                      std::sin(place[0] / 8.0));
      },
      40);
  const auto motion = testing_support::At(field, 1.0);
  const ViewImage folded =
      ByShader(Trunk({{"skin", 1.0}}, &field), {.motion = &motion}, SideCamera(48, 48));
  EXPECT_GT(std::ranges::count_if(folded.coverage, [](auto c) { return c > 0; }), 300);
  volume::Geometry grid;
  grid.size.setConstant(3);
  const ViewImage empty =
      ByShader({.ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{-1000}),
                .layers = {{"skin", 1.0}},
                .surfaces = {{"ball", BallSurface({0, 0, 0}, 20.0)}}},
               {}, SideCamera(48, 48));
  EXPECT_EQ(*std::ranges::max_element(empty.coverage), 255);  // The surface is there.
}

TEST(ShaderRays, ManyMayWorkAtATime) {
  const ViewImage alone = ByShader(Ball("skin"), {});
  std::vector<std::thread> threads;
  std::vector<ViewImage> images(3);
  for (ViewImage& image : images) {
    threads.emplace_back([&image] { image = ByShader(Ball("skin"), {}); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const ViewImage& image : images) EXPECT_EQ(image.colour.rgb, alone.colour.rgb);
}

}  // namespace
}  // namespace acus::graphics
