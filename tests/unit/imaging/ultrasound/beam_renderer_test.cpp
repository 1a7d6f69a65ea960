#include "acus/imaging/ultrasound/beams/beam_renderer.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "support/instruction_sets.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

acoustics::TissueAcousticsTable BeamRendererTable() {
  acoustics::TissueAcousticsTable table{
      .name = "test", .file = "test table", .tissues = {}, .by_hu = {}};
  table.tissues["water"] = {.speed_m_per_s = 1500,
                            .impedance_mrayl = 1.5,
                            .attenuation_db_per_cm_mhz = 0,
                            .attenuation_along_fibres_db_per_cm_mhz = 0,
                            .backscatter_db = -200};
  table.tissues["gel"] = table.tissues["water"];
  table.tissues["gel"].impedance_mrayl = 2.0;
  table.tissues["liver"] = {.backscatter_db = -40};
  table.tissues["bone"] = {.speed_m_per_s = 4080, .impedance_mrayl = 7.8, .backscatter_db = -40};
  table.tissues["air"] = {.speed_m_per_s = 343, .impedance_mrayl = 0.0004, .backscatter_db = -200};
  table.by_hu = {{-1000, "air"}, {-400, "air"}, {0, "water"}, {60, "liver"}, {1000, "bone"}};
  return table;
}

acoustics::Probe BeamRendererTestProbe(acoustics::ProbeKind kind = acoustics::ProbeKind::kLinear) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = kind;
  probe.frequency_mhz = 5;
  probe.scan_lines = 80;
  probe.samples_per_line = 300;
  probe.width_mm = 30;
  probe.depth_mm = 40;
  probe.focus_mm = 20;
  probe.image_width_px = 130;
  probe.image_height_px = 120;
  probe.dynamic_range_db = 60;
  probe.gain_db = 30;
  if (kind != acoustics::ProbeKind::kLinear) probe.field_of_view_rad = 0.9;
  if (kind == acoustics::ProbeKind::kCurvilinear) probe.radius_mm = 40;
  return probe;
}

const Eigen::Isometry3d kBeamRendererPose(Eigen::Translation3d(25, 1, 20) *
                                          Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));

image::NeedleInImage Needle() {
  image::NeedleInImage needle;
  needle.tip_in_ct_mm << 25, 20, 20;
  needle.axis_in_ct = Eigen::Vector3d(1, 1, -0.2).normalized();
  needle.length_mm = 60;
  needle.radius_mm = 0.5;
  return needle;
}

/// Tissue with a bone, pressed in by what a smooth map says.
struct BeamRendererScene {
  BeamRendererScene() : table(BeamRendererTable()) {
    RandomStream random(5, "voxels");
    ct = testing_support::SyntheticCt({60, 60, 50}, 1.0, [&](double x, double y, double) {
      return std::hypot(x - 30, y - 28) < 4 ? 900.0 : 50.0 + random.Uniform(-20.0, 20.0);
    });
    tissue.ct = &ct;
    tissue.acoustics = &table;
  }
  acoustics::TissueAcousticsTable table;
  volume::CtVolume ct;
  BeamTissue tissue;
};

class Press : public slicing::RestMap {
 public:
  explicit Press(double depth_mm) : depth_mm_(depth_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_mm,
                             const Eigen::Vector3d&) const noexcept override {
    if (depth_mm_ == 0.0) return place_mm;
    const double far = (place_mm - Eigen::Vector3d(25, 5, 20)).squaredNorm();
    return place_mm - Eigen::Vector3d(0, depth_mm_ * std::exp(-far / 200.0), 0);
  }
  double SpacingMm() const noexcept override { return 4.0; }

 private:
  double depth_mm_;
};

image::GrayImage BeamRendererImage(BeamRenderer& renderer, int threads,
                                   const slicing::RestMap* rest) {
  image::GrayImage image;
  renderer.Render(kBeamRendererPose, Needle(), image, threads, rest);
  return image;
}

volume::LabelMap BeamRendererLayers(double border_mm, const char* below) {
  volume::LabelMap labels;
  labels.geometry.size = {100, 100, 60};
  labels.geometry.spacing_mm.setConstant(0.5);
  labels.voxels.resize(labels.geometry.num_voxels());
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    labels.voxels[n] = static_cast<double>(n / 100 % 100) * 0.5 < border_mm ? 1 : 2;
  }
  labels.names = {{1, "water"}, {2, below}};
  return labels;
}

double LargestOfLine(const slicing::BeamImage& envelope, int line) {
  double most = 0.0;
  for (int k = 0; k < envelope.samples(); ++k) {
    most = std::max<double>(most, envelope.row(k)[line]);
  }
  return most;
}

TEST(BeamRenderer, GivesTheSameBitsWithAnyNumberOfThreads) {
  const BeamRendererScene scene;
  const Press press(2.0);
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear,
        acoustics::ProbeKind::kPhased}) {
    BeamOptions options;
    options.elevation_planes = 3;
    BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(kind), options);
    const image::GrayImage one = BeamRendererImage(renderer, 1, &press);
    EXPECT_GT(*std::max_element(one.pixels.begin(), one.pixels.end()), 100);
    for (const int threads : {2, 4}) {
      EXPECT_EQ(one.pixels, BeamRendererImage(renderer, threads, &press).pixels) << threads;
    }
  }
}

TEST(BeamRenderer, HasTheSameBitsOnEveryInstructionSet) {
  const BeamRendererScene scene;
  const Press press(2.0);
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(kind), BeamOptions{});
    const image::GrayImage best = BeamRendererImage(renderer, 1, &press);
    testing_support::OnEveryInstructionSet([&](const char* name) {
      EXPECT_EQ(best.pixels, BeamRendererImage(renderer, 1, &press).pixels) << name;
    });
  }
}

TEST(BeamRenderer, AMapThatMovesNothingChangesNoBit) {
  const BeamRendererScene scene;
  const Press still(0.0);
  BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(), BeamOptions{});
  EXPECT_EQ(BeamRendererImage(renderer, 1, nullptr).pixels,
            BeamRendererImage(renderer, 1, &still).pixels);
}

TEST(BeamRenderer, TheSamePlaceGivesTheSameSpeckleWhenTheProbeComesBack) {
  const BeamRendererScene scene;
  BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(), BeamOptions{});
  const image::GrayImage before = BeamRendererImage(renderer, 1, nullptr);
  image::GrayImage elsewhere;
  renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(30, 1, 25)), std::nullopt, elsewhere);
  EXPECT_NE(before.pixels, elsewhere.pixels);
  EXPECT_EQ(before.pixels, BeamRendererImage(renderer, 1, nullptr).pixels);
}

TEST(BeamRenderer, AFlatInterfaceSendsBackWhatFresnelSays) {
  const acoustics::TissueAcousticsTable table = BeamRendererTable();
  const volume::LabelMap labels = BeamRendererLayers(20.0, "gel");
  for (const int samples : {200, 400, 1600}) {
    acoustics::Probe probe = BeamRendererTestProbe();
    probe.samples_per_line = samples;
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, BeamOptions{});
    image::GrayImage image;
    renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(25, 1, 15)), std::nullopt, image);
    const double expected = (2.0 - 1.5) / (2.0 + 1.5);
    EXPECT_NEAR(20 * std::log10(LargestOfLine(renderer.envelope(), 40) / expected), 0.0, 0.1);
  }
}

TEST(BeamRenderer, ATiltedInterfaceFollowsTheLawOfItsAngle) {
  acoustics::TissueAcousticsTable table = BeamRendererTable();
  table.tissues["gel"].speed_m_per_s = 1600;
  const volume::LabelMap labels = BeamRendererLayers(20.0, "gel");
  acoustics::Probe probe = BeamRendererTestProbe();
  probe.samples_per_line = 1600;
  BeamOptions options;
  options.attenuation = false;
  options.speckle = false;
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, options);
  for (const double tilt_rad : {0.05, 0.1, 0.2, 0.3}) {
    image::GrayImage image;
    renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(25, 1, 15)) *
                        Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitZ()),
                    std::nullopt, image);
    const double cosine = std::cos(tilt_rad);
    const double expected = FresnelReflection(2.0 / 1.5, 1600.0 / 1500.0, cosine) *
                            MirrorLobe(cosine, options.lobe_deg, options.diffuse_share);
    double mean = 0.0;
    for (int line = 30; line < 50; ++line) mean += LargestOfLine(renderer.envelope(), line) / 20.0;
    EXPECT_NEAR(20 * std::log10(mean / expected), 0.0, 0.2) << tilt_rad;
  }
}

TEST(BeamRenderer, NothingIsSeenBehindBone) {
  const acoustics::TissueAcousticsTable table = BeamRendererTable();
  volume::LabelMap labels = BeamRendererLayers(20.0, "liver");
  labels.names[3] = "bone";
  labels.names[1] = "liver";
  // One voxel thick.
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    if (n / 100 % 100 == 30) labels.voxels[n] = 3;
  }
  BeamOptions options;
  options.attenuation = false;
  options.comet_tail = false;
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, BeamRendererTestProbe(), options);
  image::GrayImage image;
  renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(25, 1, 15)), std::nullopt, image);
  double before = 0.0;
  double behind = 0.0;
  const slicing::BeamImage& envelope = renderer.envelope();
  for (int k = 30; k < 90; ++k) {
    for (int l = 0; l < envelope.lines(); ++l) {
      before += envelope.row(k)[l] * envelope.row(k)[l];
      behind += envelope.row(k + 120)[l] * envelope.row(k + 120)[l];
    }
  }
  EXPECT_LT(10 * std::log10(behind / before), -40.0);
}

TEST(BeamRenderer, ANeedleIsGoneOneAndAHalfSlicesFromThePlane) {
  const acoustics::TissueAcousticsTable table = BeamRendererTable();
  const volume::LabelMap labels = BeamRendererLayers(100.0, "gel");
  const acoustics::Probe probe = BeamRendererTestProbe();
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, BeamOptions{});
  const Eigen::Isometry3d pose(Eigen::Translation3d(25, 1, 15));
  image::GrayImage image;
  double last = 1.0;
  for (const double apart_mm : {0.0, 0.5, 1.0, 15.0}) {
    image::NeedleInImage needle;
    needle.tip_in_ct_mm << 25, 21, 15 + apart_mm;
    needle.axis_in_ct = Eigen::Vector3d::UnitX();
    needle.length_mm = 50;
    needle.radius_mm = 0.4;
    renderer.Render(pose, needle, image);
    const double echo = LargestOfLine(renderer.envelope(), 20);
    EXPECT_LT(echo, last);
    last = echo;
  }
  EXPECT_LT(last, 1e-9);
}

TEST(BeamRenderer, SaysWhatIsWrong) {
  const BeamRendererScene scene;
  image::GrayImage image;
  EXPECT_THROW(BeamRenderer({}, BeamRendererTestProbe(), BeamOptions{}), InputError);
  EXPECT_THROW(BeamRenderer({.ct = &scene.ct}, BeamRendererTestProbe(), BeamOptions{}), InputError);
  acoustics::Probe flat = BeamRendererTestProbe();
  flat.depth_mm = 0.0;
  EXPECT_THROW(BeamRenderer(scene.tissue, flat, BeamOptions{}), InputError);
  acoustics::Probe fine = BeamRendererTestProbe();
  fine.frequency_mhz = 0.5;
  fine.depth_mm = 2.0;
  fine.samples_per_line = 8000;
  EXPECT_THROW(BeamRenderer(scene.tissue, fine, BeamOptions{}), InputError);
  BeamOptions even;
  even.elevation_planes = 2;
  EXPECT_THROW(BeamRenderer(scene.tissue, BeamRendererTestProbe(), even), InputError);
  const volume::LabelMap other = BeamRendererLayers(10.0, "gel");
  BeamTissue both = scene.tissue;
  both.labels = &other;
  EXPECT_THROW(BeamRenderer(both, BeamRendererTestProbe(), BeamOptions{}), InputError);
  volume::LabelMap unknown = BeamRendererLayers(10.0, "gel");
  unknown.names[2] = "cheese";
  EXPECT_THROW(BeamRenderer({.labels = &unknown, .acoustics = &scene.table},
                            BeamRendererTestProbe(), BeamOptions{}),
               InputError);
  BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(), BeamOptions{});
  Eigen::Isometry3d nowhere = kBeamRendererPose;
  nowhere.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(renderer.Render(nowhere, std::nullopt, image), InputError);
}

TEST(BeamRenderer, SurvivesPlanesOutsideAndAllGas) {
  const BeamRendererScene scene;
  image::GrayImage image;
  BeamRenderer renderer(scene.tissue, BeamRendererTestProbe(acoustics::ProbeKind::kCurvilinear),
                        BeamOptions{});
  for (const double x : {-1e9, -500.0, -40.0, 25.0, 59.0, 1e9}) {
    renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(x, 1, 20)), Needle(), image);
    EXPECT_EQ(image.pixels.size(), 130U * 120U);
  }
  const volume::CtVolume gas = testing_support::SyntheticCt(
      {30, 30, 30}, 1.0, [](double, double, double) { return -1000.0; });
  BeamTissue tissue = scene.tissue;
  tissue.ct = &gas;
  BeamRenderer in_gas(tissue, BeamRendererTestProbe(), BeamOptions{});
  in_gas.Render(Eigen::Isometry3d(Eigen::Translation3d(15, 1, 15)), std::nullopt, image);
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 0);
}

}  // namespace
}  // namespace acus::ultrasound
