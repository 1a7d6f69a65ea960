// The more expensive levels of the beam renderer, each against its closed form.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_interface.h"
#include "acus/imaging/ultrasound/beams/beam_march.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"

namespace acus::ultrasound {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

acoustics::TissueAcousticsTable Table() {
  acoustics::TissueAcousticsTable table{
      .name = "test", .file = "test table", .tissues = {}, .by_hu = {}};
  acoustics::TissueAcoustics water{.speed_m_per_s = 1500,
                                   .impedance_mrayl = 1.5,
                                   .attenuation_db_per_cm_mhz = 0,
                                   .attenuation_along_fibres_db_per_cm_mhz = 0,
                                   .backscatter_db = -200};
  table.tissues["water"] = water;
  table.tissues["fat"] = {.speed_m_per_s = 1450,
                          .impedance_mrayl = 1.38,
                          .attenuation_db_per_cm_mhz = 0,
                          .attenuation_along_fibres_db_per_cm_mhz = 0,
                          .backscatter_db = -200};
  table.tissues["muscle"] = {.impedance_mrayl = 1.7,
                             .attenuation_db_per_cm_mhz = 0.96,
                             .attenuation_along_fibres_db_per_cm_mhz = 1.40,
                             .backscatter_db = -40,
                             .fibre_ratio = 5};
  table.by_hu = {{0, "water"}};
  return table;
}

acoustics::Probe BeamEffectsTestProbe() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 5;
  probe.scan_lines = 96;
  probe.samples_per_line = 800;
  probe.width_mm = 30;
  probe.depth_mm = 40;
  probe.focus_mm = 20;
  probe.image_width_px = 128;
  probe.image_height_px = 128;
  return probe;
}

/// Label by depth: layers end at the given depths (multiples of 0.5 mm).
volume::LabelMap Layers(const std::vector<std::pair<double, std::string>>& layers) {
  volume::LabelMap labels;
  labels.geometry.size = {100, 120, 60};
  labels.geometry.spacing_mm.setConstant(0.5);
  labels.geometry.origin_mm = {0.0, 0.25, 0.0};  // Borders of voxels at multiples of 0.5 mm.
  labels.voxels.resize(labels.geometry.num_voxels());
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    const double depth_mm = static_cast<double>(n / 100 % 120) * 0.5;
    std::uint8_t label = 1;
    for (const auto& [end_mm, name] : layers) {
      labels.names[label] = name;
      if (depth_mm < end_mm) break;
      ++label;
    }
    labels.voxels[n] = label;
  }
  return labels;
}

/// Depth of the largest echo of a line within a range, mm.
double DepthOfEcho(const BeamRenderer& renderer, const slicing::BeamImage& envelope, int line,
                   double from_mm, double to_mm) {
  const double step_mm = renderer.grid().step_mm;
  int best = static_cast<int>(from_mm / step_mm);
  for (int k = best; k < static_cast<int>(to_mm / step_mm); ++k) {
    if (envelope.row(k)[line] > envelope.row(best)[line]) best = k;
  }
  return best * step_mm;
}

const Eigen::Isometry3d kPose(Eigen::Translation3d(25, 0, 15));

TEST(BeamEffects, RefractionIsSnellsLaw) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -0.5).normalized();
  const Eigen::Vector3d along = normal.unitOrthogonal();
  for (const double ratio : {0.7, 0.95, 1.0, 1.1, 2.6}) {
    for (const double angle : {0.0, 5.0, 20.0, 60.0}) {
      const double sine = ratio * std::sin(angle * kDegree);
      const Eigen::Vector3d in =
          std::cos(angle * kDegree) * normal + std::sin(angle * kDegree) * along;
      for (const double side : {-1.0, 1.0}) {
        const Eigen::Vector3d out = Refracted(in, side * normal, ratio);
        EXPECT_NEAR(out.norm(), 1.0, 1e-12);
        if (sine < 1.0) {
          EXPECT_NEAR(std::asin(out.dot(along)), std::asin(sine), 1e-9);
        } else {
          EXPECT_TRUE(out.isApprox(in));
        }
      }
    }
  }
}

TEST(BeamEffects, DepthIsThatOfTheTimeOfFlight) {
  const acoustics::TissueAcousticsTable table = Table();
  const volume::LabelMap labels = Layers({{20.0, "fat"}, {60.0, "muscle"}});
  for (const bool on : {false, true}) {
    BeamOptions options;
    options.time_of_flight = on;
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, BeamEffectsTestProbe(),
                          options);
    image::GrayImage image;
    renderer.Render(kPose, std::nullopt, image);
    const double expected_mm = on ? 20.0 * acoustics::kScannerSpeedMPerS / 1450.0 : 20.0;
    EXPECT_NEAR(DepthOfEcho(renderer, renderer.envelope(), 48, 10, 30), expected_mm,
                renderer.grid().step_mm);
  }
}

TEST(BeamEffects, LinesBendAtAFlatInterface) {
  const acoustics::TissueAcousticsTable table = Table();
  const volume::LabelMap labels = Layers({{10.0, "fat"}, {60.0, "muscle"}});
  acoustics::ScanGrid grid = acoustics::BeamGridOf(BeamEffectsTestProbe());
  const BeamPath::Frame frame{
      .grid = &grid, .index_from_ct = labels.geometry.index_from_ct(), .elevation_mm = {}};
  BeamPath path(frame);
  const double tilt = 20.0 * kDegree;
  path.Set(kPose * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitZ()), nullptr);
  BeamMarch march;
  march.Start();
  const std::vector<float> ratio(BeamMarch::kLanes, 1.0F);
  for (int k = 0; k < 400; ++k) {
    march.Place(path, Eigen::Matrix3f::Identity(), 0, BeamMarch::kLanes);
    if (k == 200) {
      for (int l = 0; l < BeamMarch::kLanes; ++l) {
        march.Bend(l, Eigen::Vector3d::UnitY(), labels.geometry.spacing_mm, 1540.0 / 1450.0, 0.0);
      }
    }
    march.Advance(ratio.data(), BeamMarch::kLanes);
  }
  const float* dx = march.Voxels().step[0];
  const float* dy = march.Voxels().step[1];
  const double expected = std::asin(1540.0 / 1450.0 * std::sin(tilt));
  for (int l = 0; l < BeamMarch::kLanes; ++l) {
    EXPECT_NEAR(std::atan2(-dx[l], dy[l]), expected, 0.1 * kDegree);
  }
}

TEST(BeamEffects, ADeeperInterfaceIsSeenAlongBentLines) {
  const acoustics::TissueAcousticsTable table = Table();
  const volume::LabelMap labels = Layers({{10.0, "fat"}, {25.0, "muscle"}, {60.0, "water"}});
  acoustics::Probe probe = BeamEffectsTestProbe();
  probe.samples_per_line = 4000;
  const double tilt = 20.0 * kDegree;
  const double bent = std::asin(1540.0 / 1450.0 * std::sin(tilt));
  for (const bool on : {false, true}) {
    BeamOptions options;
    options.refraction = on;
    options.attenuation = false;
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, options);
    image::GrayImage image;
    renderer.Render(kPose * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitZ()), std::nullopt, image);
    const int line = 48;
    const double start_mm = renderer.grid().start_mm[line].x() * std::sin(tilt);
    const double above_mm = (10.0 - start_mm) / std::cos(tilt);
    const double expected_mm = above_mm + 15.0 / std::cos(on ? bent : tilt);
    EXPECT_NEAR(DepthOfEcho(renderer, renderer.envelope(), line, 24, 30), expected_mm,
                2.0 * renderer.grid().step_mm);
  }
}

TEST(BeamEffects, ReverberationsComeBackAtEqualDistances) {
  const acoustics::TissueAcousticsTable table = Table();
  const volume::LabelMap labels = Layers({{8.0, "water"}, {11.0, "fat"}, {60.0, "water"}});
  BeamOptions options;
  options.multiple_reflections = true;
  options.face_reflection = 0.9;
  options.smallest_reflection = 0.001;
  acoustics::TissueAcousticsTable strong = table;
  strong.tissues["fat"].impedance_mrayl = 3.0;
  BeamRenderer renderer({.labels = &labels, .acoustics = &strong}, BeamEffectsTestProbe(), options);
  image::GrayImage image;
  renderer.Render(kPose, std::nullopt, image);
  const slicing::BeamImage& envelope = renderer.envelope();
  const double step_mm = renderer.grid().step_mm;
  EXPECT_NEAR(DepthOfEcho(renderer, envelope, 48, 7, 9), 8.0, step_mm);
  EXPECT_NEAR(DepthOfEcho(renderer, envelope, 48, 10, 12), 11.0, step_mm);
  EXPECT_NEAR(DepthOfEcho(renderer, envelope, 48, 13, 15), 14.0, step_mm);  // Within the layer.
  EXPECT_NEAR(DepthOfEcho(renderer, envelope, 48, 15, 16.9), 16.0, step_mm);
  EXPECT_NEAR(DepthOfEcho(renderer, envelope, 48, 23, 25), 24.0, step_mm);
  // First echo 1/3; the second once more by face and layer.
  const auto at = [&](double depth_mm) {
    return envelope.row(static_cast<int>(std::lround(depth_mm / step_mm)))[48];
  };
  EXPECT_NEAR(at(16.0) / at(8.0), 0.9 / 3.0, 0.01);
}

TEST(BeamEffects, MuscleLosesMoreAlongItsFibres) {
  const acoustics::TissueAcousticsTable table = Table();
  const volume::LabelMap labels = Layers({{60.0, "muscle"}});
  double slope_db_per_cm[2] = {};
  for (int along = 0; along < 2; ++along) {
    BeamTissue tissue{.labels = &labels, .acoustics = &table};
    tissue.fibres_in_ct["muscle"] =
        along == 1 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
    BeamOptions options;
    options.fibre_texture = false;
    BeamRenderer renderer(tissue, BeamEffectsTestProbe(), options);
    const acoustics::ScanGrid& grid = renderer.grid();
    std::vector<double> power(static_cast<std::size_t>(grid.samples), 0.0);
    for (int n = 0; n < 30; ++n) {
      image::GrayImage image;
      renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(25, 0, 0.5 + n)), std::nullopt, image);
      const slicing::BeamImage& envelope = renderer.envelope();
      for (int k = 0; k < grid.samples; ++k) {
        for (int l = 0; l < grid.lines(); ++l) {
          power[static_cast<std::size_t>(k)] += envelope.row(k)[l] * envelope.row(k)[l];
        }
      }
    }
    double xy = 0.0;
    double xx = 0.0;
    double y = 0.0;
    const int low = 60;
    const int high = 740;
    const double middle = 0.5 * (low + high - 1);
    for (int k = low; k < high; ++k) {
      const double x = (k - middle) * grid.step_mm * 0.1;
      y = 10.0 * std::log10(power[static_cast<std::size_t>(k)]);
      xy += x * y;
      xx += x * x;
    }
    slope_db_per_cm[along] = xy / xx;
  }
  EXPECT_NEAR(slope_db_per_cm[0], -2.0 * 0.96 * 5.0, 0.01 * 9.6);
  EXPECT_NEAR(slope_db_per_cm[1], -2.0 * 1.40 * 5.0, 0.01 * 14.0);
}

}  // namespace
}  // namespace acus::ultrasound
