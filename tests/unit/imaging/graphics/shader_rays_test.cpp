// The image of the shader against that of the processor, on the driver that there is: without a
// graphics card Mesa's, which computes on the processor.
#include "acus/imaging/graphics/shader_rays.h"

#include <cmath>
#include <gmock/gmock.h>
#include <random>
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

/// Every branch of the shaders, each with a probability: projections, layers, surfaces that are
/// opaque or not, breath, pressed tissue, cuts, tools with and without an image, supersampling.
struct RandomScene {
  explicit RandomScene(unsigned seed) : random(seed), field(FieldOf(DiaphragmMm, 24)) {
    if (Chance(0.3)) settings.rays.projection = volume_rendering::Projection::kMaximum;
    if (Chance(0.3)) settings.supersampling = 2;
    settings.tool_shadows = Chance(0.7);
    settings.rays.tool_shine = Chance(0.5) ? 0.35 : 0.0;
    const char* layers[] = {"skin", "bone", "soft_tissue"};
    patient = Trunk({{layers[random() % 3], Chance(0.5) ? 1.0 : 0.4}}, &field);
    for (int n = 0; n < 3; ++n) {
      patient.surfaces.push_back({"ball " + std::to_string(n),
                                  BallSurface(Place(80.0), Between(10.0, 40.0), 24),
                                  Eigen::Array3f(0.9F, 0.3F * static_cast<float>(n), 0.4F),
                                  Chance(0.3) ? 1.0 : Between(0.1, 0.9)});
    }
    motion.emplace(testing_support::At(field, Chance(0.6) ? Between(0.2, 1.2) : 0.0));
    moment.motion = &*motion;
    if (Chance(0.5)) Press();
    if (Chance(0.4)) moment.cuts = {volume_rendering::CutPlane(-Vector3d::UnitY(), Place(40.0))};
    if (Chance(0.7)) {
      moment.needle = image::NeedleInImage{Place(40.0), Vector3d(0.1, 1, 0.2).normalized(), 200, 1};
    }
    if (Chance(0.7)) AddProbe();
  }
  using Vector3d = Eigen::Vector3d;
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  bool Chance(double share) { return Between(0.0, 1.0) < share; }
  Vector3d Place(double within_mm) {
    return {Between(-within_mm, within_mm), Between(-within_mm, within_mm),
            Between(-within_mm, within_mm)};
  }
  void Press() {
    const Vector3d middle_mm(Between(-20, 20), -100.0, Between(-20, 20));
    const Eigen::AlignedBox3d box(middle_mm - Vector3d::Constant(70.0),
                                  middle_mm + Vector3d::Constant(70.0));
    pressed = PressedTissue(
        box, 5.0,
        [&](const Vector3d& x, const Vector3d&) -> Vector3d {
          const double far_2 = (x - middle_mm).squaredNorm() / 300.0;
          return x - 8.0 * std::exp(-0.5 * far_2) * Vector3d::UnitY();
        },
        1);
    moment.pressed = &pressed;
  }
  void AddProbe() {
    moment.probe.emplace();
    moment.probe->probe = &probe;
    moment.probe->ct_from_probe.translation() << Between(-20, 20), -130, Between(-20, 20);
    if (!Chance(0.5)) return;
    const image::ImageGeometry size = acoustics::ImageOf(probe);
    b_mode.Resize(size.width_px, size.height_px);
    for (std::size_t n = 0; n < b_mode.pixels.size(); ++n) {
      b_mode.pixels[n] = static_cast<std::uint8_t>((n / 7) % 256);
    }
    moment.probe->b_mode = &b_mode;
  }

  std::mt19937 random;
  breathing::MotionField field;
  std::optional<breathing::MotionMap> motion;
  PressedTissue pressed;
  acoustics::Probe probe = acoustics::DefaultProbe();
  image::GrayImage b_mode;
  PatientInView patient;
  ViewMoment moment;
  ViewSettings settings;
};

TEST(ShaderRays, RandomScenesAreThoseOfTheProcessor) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const RandomScene scene(seed);
    const Camera camera = SideCamera(96, 72);
    ExpectSameImage(ByShader(scene.patient, scene.moment, camera, scene.settings),
                    OnProcessor(scene.patient, scene.moment, camera, scene.settings));
  }
}

// More translucent surfaces on a ray than lists begin with, and fewer again.
TEST(ShaderRays, ListsGrowToWhatAnImageNeeds) {
  PatientInView patient = Ball("bone");
  for (int n = 0; n < 8; ++n) {
    patient.surfaces.push_back({"shell", BallSurface({0, 0, 0}, 30.0 + 8.0 * n, 24),
                                Eigen::Array3f(0.2F, 0.1F * static_cast<float>(n), 0.8F), 0.2});
  }
  PatientView view(patient, {});
  view.UseDevice(MakeShaderRays(DriverKind::kAny));
  for (const auto& [width, height] : {std::pair{40, 30}, {120, 90}, {40, 30}}) {
    const Camera camera = SideCamera(width, height);
    ViewImage image;
    view.Render(camera, {}, image, 1);
    ExpectSameImage(image, OnProcessor(patient, {}, camera));
  }
}

// Tissue and fields stay on the card: with each image it gets tools and the moment.
TEST(ShaderRays, SendLittleForAnImage) {
  const auto field = FieldOf(DiaphragmMm, 32, 2);
  PatientInView patient = Ball("skin", &field);
  patient.surfaces = {{"ball", BallSurface({0, 0, 0}, 40.0, 100), {0.9F, 0.3F, 0.2F}, 0.5}};
  const acoustics::Probe probe = acoustics::DefaultProbe();
  ViewMoment moment;
  moment.needle = image::NeedleInImage{{0, 0, 0}, Eigen::Vector3d(0, 1, 0.2).normalized(), 220, 1};
  moment.probe.emplace();
  moment.probe->probe = &probe;
  moment.probe->ct_from_probe.translation() << 10, -130, 20;
  PatientView view(patient, {});
  auto card = MakeShaderRays(DriverKind::kAny);
  const volume_rendering::RayDevice& device = *card;
  view.UseDevice(std::move(card));
  ViewImage image;
  std::uint64_t before = 0;
  for (int n = 0; n < 3; ++n) {
    const auto motion = testing_support::At(field, 0.1 + 0.2 * n);
    moment.motion = &motion;
    view.Render(SideCamera(32, 24), moment, image, 1);
    const std::uint64_t bytes = device.bytes_sent() - before;
    before += bytes;
    if (n == 0) {
      EXPECT_GT(bytes, 2'000'000U);
    } else {
      EXPECT_LT(bytes, 64U << 10);
      EXPECT_GT(bytes, 1000U);
    }
  }
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
