#include "acus/scene/frame_registration/pose_search.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"

namespace acus::frame_registration {
namespace {

namespace fs = std::filesystem;

acoustics::Probe SmallProbe() {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.width_mm = 40.0;
  probe.depth_mm = 40.0;
  probe.scan_lines = 128;
  probe.samples_per_line = 768;
  probe.focus_mm = probe.elevation_focus_mm = 20.0;
  probe.image_width_px = 200;
  probe.image_height_px = 200;
  probe.gain_db = 13.0;
  probe.tgc_db_per_cm = 5.0;
  probe.dynamic_range_db = 105.0;
  return probe;
}

/// Muscle around two bones, neither of which looks the same in two planes.
volume::LabelMap TwoBones() {
  volume::Geometry g;
  g.size = {140, 140, 110};
  g.spacing_mm.setConstant(0.5);
  g.origin_mm = {-35.0, -12.0, -27.0};
  volume::LabelMap labels(g, volume::Label{3});
  labels.names = {{3, "muscle"}, {5, "bone"}};
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        const Eigen::Vector3d ball = (p - Eigen::Vector3d(-9.0, 18.0, 6.0)) / 9.0;
        Eigen::Vector3d egg = p - Eigen::Vector3d(9.0, 28.0 + 0.5 * p.z(), -4.0);
        egg.x() /= 5.0;
        egg.y() /= 8.0;
        egg.z() /= 14.0;
        if (ball.norm() < 1.0 || egg.norm() < 1.0) labels.At(i, j, k) = 5;
      }
    }
  }
  return labels;
}

/// The inverse of Changed().
PoseChange ChangeOf(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double pivot_mm) {
  const Eigen::Translation3d to_pivot(0.0, pivot_mm, 0.0);
  const Eigen::Isometry3d change = to_pivot.inverse() * from.inverse() * to * to_pivot;
  const Eigen::AngleAxisd turn(change.linear());
  PoseChange out;
  out << change.translation(), turn.angle() * 180.0 / std::numbers::pi * turn.axis();
  return out;
}

class PoseSearch : public ::testing::Test {
 protected:
  PoseSearch() {
    simulated.tissue.labels = &labels;
    simulated.tissue.acoustics = &table;
    context.num_threads = 2;
    settings.samples = 400;
  }

  image::GrayImage Recorded() const {
    ultrasound::ApertureRenderer renderer(simulated.tissue, probe, simulated.options);
    image::GrayImage out;
    renderer.Render(truth, {}, out, 2);
    return out;
  }

  acoustics::Probe probe = SmallProbe();
  volume::LabelMap labels = TwoBones();
  acoustics::TissueAcousticsTable table = acoustics::ReadTissueAcoustics(
      fs::path(ACUS_SOURCE_DIR) / "configs" / "acoustics" / "tissues.json");
  SimulatedTissue simulated;
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  RunContext context;
  SearchSettings settings;
};

TEST_F(PoseSearch, FindsThePoseOfASimulatedFrameWithinItsStandardDeviations) {
  PoseChange off;
  off << 3.0, -2.0, 2.0, 2.0, -3.0, 3.0;
  const Eigen::Isometry3d start = Changed(truth, off, 20.0);
  const FramePose pose = FindFramePose(Recorded(), probe, simulated, start, settings, context);
  EXPECT_GT(pose.similarity, 0.5);
  EXPECT_GT(pose.similarity, pose.start_similarity + 0.1);
  const PoseChange error = ChangeOf(truth, pose.ct_from_probe, 20.0);
  EXPECT_LT(error.head<2>().norm(), 0.5) << error.transpose();
  EXPECT_LT(std::abs(error[5]), 1.5) << error.transpose();
  for (int k = 0; k < 6; ++k)
    EXPECT_LT(std::abs(error[k]), 3.0 * pose.sd[k]) << kChangeNames.at(static_cast<std::size_t>(k));
  EXPECT_TRUE(pose.determined(settings)[0]);
  EXPECT_TRUE(pose.determined(settings)[1]);
}

TEST_F(PoseSearch, IsTheSameWithAnyNumberOfThreads) {
  PoseChange off;
  off << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0;
  settings.samples = 60;
  const Eigen::Isometry3d start = Changed(truth, off, 20.0);
  const image::GrayImage recorded = Recorded();
  const FramePose two = FindFramePose(recorded, probe, simulated, start, settings, context);
  context.num_threads = 1;
  const FramePose one = FindFramePose(recorded, probe, simulated, start, settings, context);
  EXPECT_EQ(one.ct_from_probe.matrix(), two.ct_from_probe.matrix());
  EXPECT_EQ(one.covariance, two.covariance);
}

// A bone that is the same in all planes tells nothing of the place along it.
TEST_F(PoseSearch, SaysThatThePlaceAlongABarIsNotDetermined) {
  for (int k = 0; k < labels.geometry.size[2]; ++k) {
    for (int j = 0; j < labels.geometry.size[1]; ++j) {
      for (int i = 0; i < labels.geometry.size[0]; ++i) {
        const Eigen::Vector3d p = labels.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
        const Eigen::Vector2d across(p.x() / 9.0, (p.y() - 20.0 - 0.4 * p.x()) / 6.0);
        labels.At(i, j, k) = across.norm() < 1.0 ? 5 : 3;
      }
    }
  }
  settings.samples = 200;
  const FramePose pose = FindFramePose(Recorded(), probe, simulated, truth, settings, context);
  EXPECT_GT(pose.sd[2], 0.9 * settings.start_mm);
  EXPECT_FALSE(pose.determined(settings)[2]);
  EXPECT_TRUE(pose.determined(settings)[1]);
}

TEST_F(PoseSearch, RefusesAFrameOfAnotherSize) {
  image::GrayImage frame;
  frame.Resize(100, 200);
  EXPECT_THROW(FindFramePose(frame, probe, simulated, truth, settings, context), InputError);
}

TEST_F(PoseSearch, RefusesAnEvenFrame) {
  image::GrayImage frame;
  frame.Resize(200, 200);
  EXPECT_THROW(FindFramePose(frame, probe, simulated, truth, settings, context), InputError);
}

TEST_F(PoseSearch, HasNoAnswerForAFrameThatNothingExplains) {
  image::GrayImage frame;
  frame.Resize(200, 200);
  for (std::size_t n = 0; n < frame.pixels.size(); ++n) {  // Stripes from the top to the bottom.
    frame.pixels[n] = n % 20 < 10 ? 40 : 160;
  }
  settings.samples = 20;
  std::ranges::fill(labels.voxels, volume::Label{3});
  EXPECT_THROW(FindFramePose(frame, probe, simulated, truth, settings, context), NoAnswerError);
}

}  // namespace
}  // namespace acus::frame_registration
