// Frames recorded over a fibula whose surface is known from CT, beside the same frames simulated
// from that surface and one even soft tissue: how bone looks, by the same measures.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "acus/data/mesh/surface_io.h"
#include "acus/imaging/ultrasound/aperture_renderer.h"
#include "support/shared_data.h"

namespace acus::ultrasound {
namespace {

namespace fs = std::filesystem;

// Of the recordings.
constexpr int kWidthPx = 950;
constexpr int kHeightPx = 811;
constexpr double kMmPerPx = 0.05392;

Eigen::Isometry3d BonePose(const Eigen::Vector3d& place_mm, const Eigen::Vector3d& euler_deg) {
  const Eigen::Vector3d angle = euler_deg * std::numbers::pi / 180.0;
  return Eigen::Translation3d(place_mm) * Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
}

struct BoneFrame {
  fs::path image;
  Eigen::Isometry3d image_from_ct;
};

std::vector<BoneFrame> BoneFrames(const fs::path& folder) {
  const Eigen::Isometry3d marker_from_image =
      BonePose({26.44694442, -0.52572229, 128.00100047}, {92.48865621, -0.46874914, 179.2277322});
  std::vector<BoneFrame> frames;
  std::ifstream in(folder / "sweep_initial.csv");
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    std::string time;
    double scale = 0.0;
    Eigen::Vector3d place;
    Eigen::Vector3d euler;
    row >> time >> scale >> place.x() >> place.y() >> place.z() >> euler.x() >> euler.y() >>
        euler.z();
    frames.push_back({.image = folder / "frames" / (time + ".png"),
                      .image_from_ct = (BonePose(place, euler) * marker_from_image).inverse()});
  }
  return frames;
}

/// The bone around the plane of one frame: labels, and where beams meet its surface.
struct BoneInPlane {
  volume::LabelMap labels;
  std::vector<double> depth_mm = std::vector<double>(kWidthPx, -1.0);  ///< By column; -1: none.
  std::vector<double> cosine = std::vector<double>(kWidthPx, 0.0);

  int columns() const {
    return static_cast<int>(
        std::count_if(depth_mm.begin(), depth_mm.end(), [](double d) { return d > 0.0; }));
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
  BoneInPlane bone{.labels = volume::LabelMap(geometry, volume::Label{3})};
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
      if (depth <= 0.0 || (bone.depth_mm[n] > 0.0 && bone.depth_mm[n] < depth)) continue;
      bone.depth_mm[n] = depth;
      bone.cosine[n] = std::abs(normal.y());
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

/// Mean over some rows and 13 columns; beyond the image: its edge.
double MeanGrey(const cv::Mat& image, double first_row, double last_row, int column) {
  double sum = 0.0;
  int count = 0;
  for (int r = static_cast<int>(first_row); r <= static_cast<int>(last_row); ++r) {
    for (int c = column - 6; c <= column + 6; c += 2, ++count) {
      sum += image.at<std::uint8_t>(std::clamp(r, 0, image.rows - 1),
                                    std::clamp(c, 0, image.cols - 1));
    }
  }
  return sum / std::max(1, count);
}

double MedianOf(std::vector<double> values, double quantile = 0.5) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size()))];
}

using BoneMeasures = std::map<std::string, std::vector<double>>;

/// Adds the medians over one frame's columns.
void MeasureBone(const cv::Mat& image, const BoneInPlane& bone, BoneMeasures& measures) {
  BoneMeasures columns;
  for (int c = 20; c < kWidthPx - 40; c += 8) {
    const double depth_mm = bone.depth_mm[static_cast<std::size_t>(c)];
    if (depth_mm < 6.0 || depth_mm + 10.0 > kHeightPx * kMmPerPx) continue;
    // The registration is good to a millimetre or two: the ridge itself is searched.
    double level = -1.0;
    int ridge = 0;
    for (int r = static_cast<int>((depth_mm - 2.5) / kMmPerPx); r <= (depth_mm + 2.5) / kMmPerPx;
         ++r) {
      const double mean = MeanGrey(image, r - 2, r + 2, c);
      if (mean > level) {
        level = mean;
        ridge = r;
      }
    }
    const double degrees = std::acos(std::min(1.0, bone.cosine[static_cast<std::size_t>(c)])) *
                           180.0 / std::numbers::pi;
    columns[degrees < 20.0   ? "level, 0 to 20 degrees"
            : degrees < 40.0 ? "level, 20 to 40 degrees"
                             : "level, over 40 degrees"]
        .push_back(level);
    const double above = MeanGrey(image, ridge - 3.5 / kMmPerPx, ridge - 2.0 / kMmPerPx, c);
    if (degrees >= 40.0 || level - above < 30.0) continue;
    const double half = 0.5 * (above + level);
    int low = ridge;
    int high = ridge;
    while (ridge - low < 80 && MeanGrey(image, low - 1, low + 1, c) > half) --low;
    while (high - ridge < 80 && MeanGrey(image, high - 1, high + 1, c) > half) ++high;
    columns["thickness, mm"].push_back((high - low) * kMmPerPx);
    columns["fall, 3 mm below"].push_back(
        MeanGrey(image, ridge + 2.2 / kMmPerPx, ridge + 4.2 / kMmPerPx, c) - level);
    columns["fall, 8 mm below"].push_back(
        MeanGrey(image, ridge + 7.0 / kMmPerPx, ridge + 9.0 / kMmPerPx, c) - level);
  }
  for (const auto& [name, values] : columns) measures[name].push_back(MedianOf(values));
}

/// The probe's frequency, gain, TGC and compression are not known: chosen so that the grey of soft
/// tissue and of bone at a right angle is that of every second frame.
acoustics::Probe BoneProbe() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.fractional_bandwidth = 0.7;
  probe.width_mm = kWidthPx * kMmPerPx;
  probe.depth_mm = kHeightPx * kMmPerPx;
  probe.scan_lines = 256;
  probe.samples_per_line = 1024;
  probe.focus_mm = probe.elevation_focus_mm = 20.0;
  probe.image_width_px = kWidthPx;
  probe.image_height_px = kHeightPx;
  probe.gain_db = 13.0;
  probe.tgc_db_per_cm = 5.0;
  probe.dynamic_range_db = 105.0;
  return probe;
}

TEST(BoneInUltrasound, SimulatedFramesLieBetweenTheQuartilesOfTheRecordedOnes) {
  const auto folder = testing_support::SharedData("ultrasound/bone_leg");
  if (!folder) GTEST_SKIP() << "test data ultrasound/bone_leg is not here";
  const mesh::Surface fibula = mesh::ReadSurface(*folder / "Fibula.stl");
  acoustics::TissueAcousticsTable table = acoustics::ReadTissueAcoustics(
      fs::path(ACUS_SOURCE_DIR) / "configs" / "acoustics" / "tissues.json");
  table.tissues.at("muscle").attenuation_db_per_cm_mhz = 0.6;
  table.tissues.at("muscle").backscatter_db = -50.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().x() = 0.5 * kWidthPx * kMmPerPx;
  BoneMeasures recorded;
  BoneMeasures simulated;
  for (const BoneFrame& frame : BoneFrames(*folder)) {
    const BoneInPlane bone = BoneAround(fibula, frame.image_from_ct);
    if (bone.columns() < 80) continue;
    const cv::Mat real = cv::imread(frame.image.string(), cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(real.cols, kWidthPx) << frame.image;
    MeasureBone(real, bone, recorded);
    ApertureRenderer renderer({.labels = &bone.labels, .acoustics = &table}, BoneProbe(),
                              ApertureOptions());
    image::GrayImage image;
    renderer.Render(pose, {}, image, 2);
    MeasureBone(cv::Mat(image.height, image.width, CV_8U, image.pixels.data()), bone, simulated);
  }
  ASSERT_EQ(recorded.size(), 6U);
  for (const auto& [name, values] : recorded) {
    const double median = MedianOf(simulated.at(name));
    EXPECT_GE(median, MedianOf(values, 0.25)) << name << ", recorded " << MedianOf(values);
    EXPECT_LE(median, MedianOf(values, 0.75)) << name << ", recorded " << MedianOf(values);
  }
}

}  // namespace
}  // namespace acus::ultrasound
