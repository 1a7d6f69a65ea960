// Poses of recorded frames over a fibula whose surface is known from CT, found by simulation from
// starts that are 5 mm and 5 degrees off.
//
// The tracked poses are themselves good to a millimetre or two, and where a plane cuts a bone like
// a bar, the frame says little of places along it. What is measured is what the frame shows: the
// distance between the bone's visible surface in the tracked plane and in the plane that was found,
// in the image.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/patient/segmentation/voxels/rasterise.h"
#include "acus/scene/frame_registration/frame_patient.h"
#include "acus/scene/frame_registration/pose_search.h"
#include "support/leg_sweep.h"
#include "support/shared_data.h"

namespace acus::frame_registration {
namespace {

using testing_support::LegFrame;

constexpr int kWidthPx = testing_support::kLegWidthPx;
constexpr int kHeightPx = testing_support::kLegHeightPx;
constexpr double kMmPerPx = testing_support::kLegMmPerPx;
constexpr double kHalfWidthMm = 0.5 * kWidthPx * kMmPerPx;
/// The tracked poses are off by a constant in the image: the mean shift of the bone, lateral and
/// axial, by fits of every second frame, none of which is looked at here. It is taken out.
const Eigen::Translation3d kOffsetMm(-0.79, -0.31, 0.0);
/// Every so many frames are looked at here; docs/models/frame_registration.md has all.
constexpr std::size_t kStride = 8;

/// The probe's origin is the middle of its face.
Eigen::Isometry3d CtFromProbe(const LegFrame& frame) {
  return frame.ct_from_image * Eigen::Translation3d(kHalfWidthMm, 0.0, 0.0);
}

using Segment = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

/// Where a plane cuts the surface, in mm of the image.
std::vector<Segment> CutOf(const mesh::Surface& surface, const Eigen::Isometry3d& ct_from_probe) {
  const Eigen::Matrix3Xd nodes = ct_from_probe.inverse() * surface.nodes_mm;
  std::vector<Segment> out;
  for (const auto& triangle : surface.triangles.colwise()) {
    std::vector<Eigen::Vector2d> ends;
    for (int n = 0; n < 3; ++n) {
      const Eigen::Vector3d a = nodes.col(triangle(n));
      const Eigen::Vector3d b = nodes.col(triangle((n + 1) % 3));
      if ((a.z() < 0.0) == (b.z() < 0.0)) continue;
      ends.emplace_back((a + a.z() / (a.z() - b.z()) * (b - a)).head<2>());
    }
    if (ends.size() == 2) out.emplace_back(ends[0], ends[1]);
  }
  return out;
}

/// The first point of the surface on each of 237 lines down from the face.
std::vector<Eigen::Vector2d> VisibleOf(const std::vector<Segment>& cut) {
  std::vector<Eigen::Vector2d> out;
  for (int column = 2; column < kWidthPx; column += 4) {
    const double x = column * kMmPerPx - kHalfWidthMm;
    double depth = 1e9;
    for (const auto& [a, b] : cut) {
      if ((a.x() < x) == (b.x() < x)) continue;
      depth = std::min(depth, a.y() + (x - a.x()) / (b.x() - a.x()) * (b.y() - a.y()));
    }
    if (depth > 0.0 && depth < kHeightPx * kMmPerPx) out.emplace_back(x, depth);
  }
  return out;
}

double RmsDistance(const std::vector<Eigen::Vector2d>& points, const std::vector<Segment>& cut) {
  double sum = 0.0;
  for (const Eigen::Vector2d& p : points) {
    double nearest = 1e18;
    for (const auto& [a, b] : cut) {
      const Eigen::Vector2d along = b - a;
      const double at =
          std::clamp((p - a).dot(along) / std::max(1e-12, along.squaredNorm()), 0.0, 1.0);
      nearest = std::min(nearest, (a + at * along - p).squaredNorm());
    }
    sum += nearest;
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

volume::LabelMap LegAround(const mesh::Surface& fibula, const Eigen::AlignedBox3d& box) {
  constexpr double kVoxelMm = 0.5;
  volume::Geometry g;
  g.size = (box.sizes() / kVoxelMm).array().ceil().cast<int>() + 1;
  g.spacing_mm.setConstant(kVoxelMm);
  g.origin_mm = box.min();
  volume::LabelMap labels(g, volume::Label{3});
  labels.names = {{3, "muscle"}, {5, "bone"}};
  segmentation::PaintInside(fibula, segmentation::CheckClosed(fibula, "Fibula.stl"), 5, 2, labels);
  return labels;
}

/// 5 mm and 5 degrees in random directions.
PoseChange OffBy5(std::uint64_t frame) {
  RandomStream random(1, "start", frame);
  PoseChange out;
  for (int k = 0; k < 6; ++k) out[k] = random.Normal();
  out.head<3>() *= 5.0 / out.head<3>().norm();
  out.tail<3>() *= 5.0 / out.tail<3>().norm();
  return out;
}

TEST(FrameRegistration, FindsTheBoneOfRecordedFramesFromStartsThatAreFiveMillimetresOff) {
  const auto folder = testing_support::SharedData("ultrasound/bone_leg");
  if (!folder) GTEST_SKIP() << "test data ultrasound/bone_leg is not here";
  const mesh::Surface fibula = mesh::ReadSurface(*folder / "Fibula.stl");
  const acoustics::TissueAcousticsTable table = testing_support::LegTissues();
  const acoustics::Probe probe = testing_support::LegProbe();
  const std::vector<LegFrame> frames = testing_support::LegFrames(*folder);
  int within = 0;
  int count = 0;
  double before_mm = 0.0;
  double after_mm = 0.0;
  for (std::size_t n = 1; n < frames.size(); n += kStride) {
    const Eigen::Isometry3d ct_from_probe = CtFromProbe(frames[n]);
    const auto visible = VisibleOf(CutOf(fibula, ct_from_probe));
    if (visible.size() < 20) continue;
    const Eigen::Isometry3d start = Changed(ct_from_probe, OffBy5(n), 0.5 * probe.depth_mm);
    const volume::LabelMap labels = LegAround(fibula, FieldOfViewBox(probe, start, 12.0));
    cv::Mat pixels = cv::imread(frames[n].image.string(), cv::IMREAD_GRAYSCALE);
    image::GrayImage frame;
    frame.Resize(pixels.cols, pixels.rows);
    pixels.copyTo(cv::Mat(frame.height, frame.width, CV_8U, frame.pixels.data()));
    SimulatedTissue simulated;
    simulated.tissue.labels = &labels;
    simulated.tissue.acoustics = &table;
    RunContext context;
    context.num_threads = 2;
    const FramePose pose = FindFramePose(frame, probe, simulated, start, SearchSettings(), context);
    const double off_mm = RmsDistance(visible, CutOf(fibula, pose.ct_from_probe * kOffsetMm));
    std::printf("frame %zu: %.2f mm, with the offset %.2f mm, start %.2f mm\n", n, off_mm,
                RmsDistance(visible, CutOf(fibula, pose.ct_from_probe)),
                RmsDistance(visible, CutOf(fibula, start)));
    before_mm += RmsDistance(visible, CutOf(fibula, start));
    after_mm += off_mm;
    within += off_mm <= 1.0 ? 1 : 0;
    ++count;
  }
  ASSERT_GE(count, 6);
  EXPECT_GE(10 * within, 8 * count) << within << " of " << count << " within 1 mm";
  EXPECT_LT(after_mm, 0.4 * before_mm);
}

}  // namespace
}  // namespace acus::frame_registration
