// Frames recorded over a fibula whose surface is known from CT, beside the same frames simulated
// from that surface and one even soft tissue: how bone looks, by the same measures.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "acus/data/mesh/surface_io.h"
#include "acus/imaging/ultrasound/aperture_renderer.h"
#include "support/leg_sweep.h"
#include "support/shared_data.h"

namespace acus::ultrasound {
namespace {

using testing_support::LegFrame;

constexpr int kWidthPx = testing_support::kLegWidthPx;
constexpr int kHeightPx = testing_support::kLegHeightPx;
constexpr double kMmPerPx = testing_support::kLegMmPerPx;

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

TEST(BoneInUltrasound, SimulatedFramesLieBetweenTheQuartilesOfTheRecordedOnes) {
  const auto folder = testing_support::SharedData("ultrasound/bone_leg");
  if (!folder) GTEST_SKIP() << "test data ultrasound/bone_leg is not here";
  const mesh::Surface fibula = mesh::ReadSurface(*folder / "Fibula.stl");
  const acoustics::TissueAcousticsTable table = testing_support::LegTissues();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().x() = 0.5 * kWidthPx * kMmPerPx;
  BoneMeasures recorded;
  BoneMeasures simulated;
  for (const LegFrame& frame : testing_support::LegFrames(*folder)) {
    const BoneInPlane bone = BoneAround(fibula, frame.ct_from_image.inverse());
    if (bone.columns() < 80) continue;
    const cv::Mat real = cv::imread(frame.image.string(), cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(real.cols, kWidthPx) << frame.image;
    MeasureBone(real, bone, recorded);
    ApertureRenderer renderer({.labels = &bone.labels, .acoustics = &table},
                              testing_support::LegProbe(), ApertureOptions());
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
