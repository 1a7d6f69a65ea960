// Known answers on public recordings.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/random.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/session_import.h"
#include "acus/patient/registration/landmark_registration.h"
#include "acus/patient/registration/pivot.h"
#include "acus/patient/registration/touches.h"
#include "acus/patient/registration/tracker_quality.h"
#include "support/shared_data.h"

namespace acus::registration {
namespace {

TEST(PivotData, GivesTheStatedAnswer) {
  const auto folder = testing_support::SharedData("registration/pivot");
  if (!folder) GTEST_SKIP() << "test data registration/pivot is not here";
  const auto poses = ReadPoses(*folder);
  ASSERT_EQ(poses.size(), 57U);
  const PivotCalibration result = CalibratePivot(poses);
  // All printed digits of the stated answer.
  EXPECT_LT((result.tip_mm - Eigen::Vector3d(-14.473, 394.634, -7.407)).cwiseAbs().maxCoeff(),
            6e-4);
  EXPECT_LT((result.pivot_mm - Eigen::Vector3d(-804.742, -85.474, -2112.131)).cwiseAbs().maxCoeff(),
            6e-4);
  EXPECT_NEAR(result.residual_coordinate_rms_mm, 1.761, 6e-4);
}

TEST(PivotData, StaysThereWhenLeavingOutPosesThatDoNotFit) {
  const auto folder = testing_support::SharedData("registration/pivot");
  if (!folder) GTEST_SKIP() << "test data registration/pivot is not here";
  const auto poses = ReadPoses(*folder);
  const PivotCalibration all = CalibratePivot(poses);
  const PivotCalibration robust = CalibratePivotRobustly(poses);
  EXPECT_LE(robust.residual_rms_mm, all.residual_rms_mm);
  EXPECT_LT((robust.tip_mm - all.tip_mm).norm(), 5.0 * all.tip_sd_mm.norm());
}

/// The pointer of PLUS's device set for the landmark run: StylusTipToStylus of
/// PlusDeviceSet_fCal_Sim_RecordPhantomLandmarks.xml (PlusLibData, BSD-3).
const Eigen::Vector3d kStylusTipMm(108.565, 7.77385, 2.5389);

session::PoseStream ReadTool(const std::filesystem::path& path, const std::string& tool,
                             const std::string& reference) {
  session::ImportOptions options;
  options.needle_frames = {tool};
  options.probe_frames = {};
  options.reference_frame = reference;
  return session::ReadPlusSession(path, options, RunContext{}).session.needle;
}

TouchSettings LikePlus() {
  TouchSettings settings;
  settings.shaft_mm = 30.0;        // It pivots at each landmark.
  settings.average_from_s = 0.05;  // PLUS averages the second to the fifth sample of a rest.
  settings.average_to_s = 0.3;
  return settings;
}

TEST(PlusData, TheLandmarkRunGivesThePublishedRegistration) {
  const auto run = testing_support::SharedData(
      "sessions/plus/EightLandmarkPointsTrackedForPhantomRegistration.igs.mha");
  const auto published = testing_support::SharedData(
      "registration/plus/PhantomRegistrationLandmarkDetection.results.xml");
  if (!run || !published) GTEST_SKIP() << "test data sessions/plus is not here";
  const auto stream = ReadTool(*run, "Stylus", "Reference");
  ASSERT_EQ(stream.size(), 1000U);
  const auto touches = FindTouches(stream, kStylusTipMm, LikePlus());
  const transforms::Landmarks phantom = transforms::ReadLandmarks(*published);
  const transforms::Landmarks touched = NamedTouches(touches, phantom, run->string());
  // As PLUS does: from the phantom to the reference.
  const MarkerFit fit = FitMarkers(phantom.points_mm, touched.points_mm);
  const Eigen::Isometry3d theirs(
      session::ReadPlusCalibrations(*published).at("PhantomToReference"));
  EXPECT_LT((fit.ct_from_reference.translation() - theirs.translation()).norm(), 0.1);
  const double turn_rad =
      Eigen::AngleAxisd(fit.ct_from_reference.linear().transpose() * theirs.linear()).angle();
  EXPECT_LT(turn_rad * 180 / std::numbers::pi, 0.2);  // As PLUS's own test of it allows.
  const transforms::Markers apart_mm =
      fit.ct_from_reference * phantom.points_mm - theirs * phantom.points_mm;
  EXPECT_LT(std::sqrt(apart_mm.squaredNorm() / 8.0), 0.1);
  EXPECT_NEAR(fit.residual_mm.colwise().norm().mean(), 0.198046, 0.01);  // Their "Error".
  // Averaging all that was recorded at each landmark moves them by what the tip wanders.
  TouchSettings whole;
  whole.shaft_mm = 30.0;
  const auto averaged = NamedTouches(FindTouches(stream, kStylusTipMm, whole), phantom, "run");
  EXPECT_LT((averaged.points_mm - touched.points_mm).colwise().norm().maxCoeff(), 1.2);
}

TEST(PlusData, ExactLandmarksGiveThePublishedRegistration) {
  const auto published =
      testing_support::SharedData("registration/plus/PhantomRegistration.results.xml");
  if (!published) GTEST_SKIP() << "test data registration/plus is not here";
  // Their simulated tracker touches the landmarks of a phantom that stands at (-75, -50, -150).
  const transforms::Landmarks phantom = transforms::ReadLandmarks(*published);
  ASSERT_EQ(phantom.points_mm.cols(), 8);
  const transforms::Markers touched_mm =
      phantom.points_mm.colwise() + Eigen::Vector3d(-75, -50, -150);
  const auto fit = FitMarkers(phantom.points_mm, touched_mm);
  const auto theirs = session::ReadPlusCalibrations(*published).at("PhantomToReference");
  EXPECT_LT((fit.ct_from_reference.matrix() - theirs).cwiseAbs().maxCoeff(), 1e-3);
}

// Their stylus calibration is of a simulated tracker: a pointer of 210 mm along x, its length
// uniform within +-1 mm, turned by up to 60 degrees about y and z. Which of its poses were read
// depends on the clock, so that only the answer and the size of what remains can be compared (their
// test: 0.5 mm).
TEST(PlusData, AStylusLikeTheirsGivesThePublishedTip) {
  const auto published =
      testing_support::SharedData("registration/plus/StylusCalibration.results.xml");
  if (!published) GTEST_SKIP() << "test data registration/plus is not here";
  const auto theirs = session::ReadPlusCalibrations(*published).at("StylusTipToStylus");
  std::vector<Eigen::Isometry3d> poses;
  RandomStream random(1, "stylus");
  for (int i = 0; i < 200; ++i) {
    const double limit = 60.0 * std::numbers::pi / 180.0;
    Eigen::Isometry3d pose(Eigen::Translation3d(205, 305, 55));
    pose.rotate(Eigen::AngleAxisd(random.Uniform(-limit, limit), Eigen::Vector3d::UnitY()));
    pose.rotate(Eigen::AngleAxisd(random.Uniform(-limit, limit), Eigen::Vector3d::UnitZ()));
    pose.translate(Eigen::Vector3d(-random.Uniform(209, 211), 0, 0));
    poses.push_back(i % 20 == 7 ? Eigen::Isometry3d(Eigen::Translation3d(7.0 * i, -500, 90))
                                : pose);
  }
  const PivotCalibration result = CalibratePivotRobustly(poses);
  EXPECT_LT((result.tip_mm - theirs.topRightCorner<3, 1>()).norm(), 0.3);
  EXPECT_NEAR(result.residual_rms_mm, 1.0 / std::sqrt(3.0), 0.04);  // Of a uniform error.
  EXPECT_EQ(std::ranges::count(result.used, true), 190);
}

// The 5000 poses of an electromagnetic tracker: a stylus and a reference that lie still, a probe
// that moves. Its numbers come in steps of 0.11 mm.
TEST(PlusData, TheTrackerLogHasTheJitterOfThe2010Paper) {
  const auto log =
      testing_support::SharedData("sessions/plus/WaterTankBottomTranslationTrackerBuffer.igs.mha");
  if (!log) GTEST_SKIP() << "test data sessions/plus is not here";
  const Jitter stylus = MeasureJitter(ReadTool(*log, "Stylus", "Tracker"), "Stylus", 1.0);
  EXPECT_NEAR(stylus.rms_mm, 0.172, 0.002);  // 0.173 mm in the paper, with another tracker.
  EXPECT_GT(stylus.duration_s, 100.0);
  EXPECT_LT(stylus.noise_mm, 0.05);  // Most of it is slow.
  EXPECT_NEAR(stylus.step_mm, 0.111, 0.002);
  const Jitter probe = MeasureJitter(ReadTool(*log, "Probe", "Tracker"), "Probe", 1.0);
  EXPECT_FALSE(probe.whole_recording);
  EXPECT_LT(probe.duration_s, 10.0);
}

}  // namespace
}  // namespace acus::registration
