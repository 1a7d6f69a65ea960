// Public recordings: every file reads, and published metrics come out.
#include <cmath>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <map>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_import.h"
#include "acus/data/transforms/itk_transform_file.h"
#include "acus/run/training/motion_metrics.h"
#include "support/fuzz.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::SharedData;

#define FIND_OR_SKIP(variable, name)                                       \
  const auto variable##_found = SharedData(name);                          \
  if (!variable##_found) GTEST_SKIP() << "test data " name " is not here"; \
  const fs::path variable = *variable##_found

struct Expected {
  const char* file;
  std::size_t width, height, frames;
  PixelType type;
};

class PlusFile : public testing::TestWithParam<Expected> {};

TEST_P(PlusFile, ReadsWhole) {
  FIND_OR_SKIP(folder, "sessions/plus");
  SequenceFile file(folder / GetParam().file);
  EXPECT_EQ(file.num_frames(), GetParam().frames);
  EXPECT_EQ(file.header().width, GetParam().width);
  EXPECT_EQ(file.header().height, GetParam().height);
  EXPECT_EQ(file.header().pixel_type, GetParam().type);
  for (std::size_t i = 0; i < file.num_frames(); ++i) {
    EXPECT_NO_THROW(file.Transforms(i));
    if (!file.has_images()) continue;
    EXPECT_EQ(file.ReadImage(i).size(), file.header().bytes_per_frame());
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, PlusFile,
    testing::Values(
        Expected{"SpinePhantomFreehand.igs.mha", 820, 616, 21, PixelType::kUint8},
        Expected{"BoneUltrasound_L14.igs.mha", 820, 616, 21, PixelType::kUint8},
        Expected{"fCal_Test_Calibration_3NWires.igs.mha", 820, 616, 188, PixelType::kUint8},
        Expected{"fCal_Test_Validation_3NWires.igs.mha", 820, 616, 94, PixelType::kUint8},
        Expected{"UltrasonixLinearRfData.igs.mha", 2080, 256, 1, PixelType::kInt16},
        Expected{"TimestampFilteringTest.igs.mha", 1, 1, 500, PixelType::kUint8},
        Expected{"TransformInterpolationTest.igs.mha", 1, 1, 500, PixelType::kUint8},
        Expected{"WaterTankBottomTranslationTrackerBuffer.igs.mha", 0, 0, 5000, PixelType::kUint8},
        Expected{"EightLandmarkPointsTrackedForPhantomRegistration.igs.mha", 0, 0, 1000,
                 PixelType::kNone},
        Expected{"NrrdSample.igs.nrrd", 256, 256, 1, PixelType::kInt16}),
    [](const auto& param) {
      return std::string(param.param.file, std::strcspn(param.param.file, "."));
    });

TEST(PlusData, ReadsAPairWithoutItsPixels) {
  FIND_OR_SKIP(path, "sessions/plus/MetaImageSequenceIOTest1.igs.mhd");
  SequenceFile file(path);
  ASSERT_EQ(file.num_frames(), 567U);
  EXPECT_EQ(file.header().Field(3, "CustomTransform"), "3 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
  EXPECT_EQ(file.Transforms(0).Find("Image", "Tool")->to_from_from, Eigen::Matrix4d::Identity());
  EXPECT_THAT([&] { file.ReadImage(0); },
              ThrowsMessage<InputError>(HasSubstr("MetaImageSequenceIOTest1.zraw")));
}

TEST(PlusData, GivesTheProbeInTheReferenceFrame) {
  FIND_OR_SKIP(path, "sessions/plus/SpinePhantomFreehand.igs.mha");
  const auto imported = ReadAnySession(path, {}, RunContext{});
  EXPECT_EQ(imported.probe_frame, "Probe");
  EXPECT_EQ(imported.needle_frame, "Stylus");
  ASSERT_EQ(imported.session.probe.size(), 21U);
  EXPECT_EQ(imported.session.probe.front().time_ns, 215'102'186'000);
  // By hand for the first frame: tracker_from_reference^-1 * tracker_from_probe.
  Eigen::Matrix4d probe;
  probe << 0.231245, 0.951424, -0.203269, 172.641, -0.127436, -0.17751, -0.975833, -98.0022,
      -0.964513, 0.25156, 0.0801977, -22.0262, 0, 0, 0, 1;
  Eigen::Matrix4d reference;
  reference << 0.949536, -0.208383, 0.234431, 264.096, -0.195717, -0.977686, -0.076326, 93.8733,
      0.245105, 0.0265923, -0.969132, 3.0506, 0, 0, 0, 1;
  const Eigen::Matrix4d truth = reference.inverse() * probe;
  const auto& pose = imported.session.probe.front().reference_from_tool;
  EXPECT_LT((pose.matrix() - truth).cwiseAbs().maxCoeff(), 1e-4);  // Six digits in the file.
  for (const PoseSample& sample : imported.session.probe) EXPECT_TRUE(sample.valid);
}

TEST(PlusData, FindsTheTransducerThroughACalibration) {
  FIND_OR_SKIP(path, "sessions/plus/SpinePhantomFreehand.igs.mha");
  FIND_OR_SKIP(config, "sessions/plus/PlusDeviceSet_Server_SimulatedUltrasound_3DSlicer.xml");
  ImportOptions options;
  options.calibrations = ReadPlusCalibrations(config);
  const auto imported = ReadPlusSession(path, options, RunContext{});
  EXPECT_EQ(imported.probe_frame, "TransducerOriginPixel");
  ASSERT_TRUE(imported.probe_mm_per_px);
  EXPECT_NEAR(imported.probe_mm_per_px->x(), 0.0861, 1e-4);
  EXPECT_NEAR(imported.probe_mm_per_px->y(), 0.0861, 1e-4);
  // The middle of the face, pixel (410, -5), lies at that place on the probe, in every frame.
  const auto rigid = ReadPlusSession(path, {}, RunContext{});
  const Eigen::Vector3d face_on_probe_mm =
      (options.calibrations.at("ImageToProbe") * Eigen::Vector4d(410, -5, 0, 1)).head<3>();
  for (std::size_t i = 0; i < 21; ++i) {
    const Eigen::Vector3d face = imported.session.probe[i].reference_from_tool.translation();
    const Eigen::Vector3d expected = rigid.session.probe[i].reference_from_tool * face_on_probe_mm;
    EXPECT_LT((face - expected).norm(), 2e-3) << i;
  }
}

TEST(PlusData, MarksTheFrameThatTheTrackerDidNotSee) {
  FIND_OR_SKIP(path, "sessions/plus/TransformInterpolationTest.igs.mha");
  const auto imported = ReadPlusSession(path, {}, RunContext{});
  const auto& probe = imported.session.probe;
  EXPECT_EQ(std::ranges::count(probe, false, &PoseSample::valid), 1);
  const auto lost = std::ranges::find(probe, false, &PoseSample::valid);
  ASSERT_NE(lost, probe.begin());
  EXPECT_EQ(lost->reference_from_tool, (lost - 1)->reference_from_tool);
}

/// The rows of TrueMetricsTable.tsv: "Path Length|Any = ImageToReference" -> value.
std::map<std::string, double> PublishedMetrics(const fs::path& path) {
  std::map<std::string, double> metrics;
  std::ifstream file(path);
  std::string name, roles, unit, value;
  while (std::getline(file, name, '\t') && std::getline(file, roles, '\t') &&
         std::getline(file, unit, '\t') && std::getline(file, value)) {
    metrics[name + "|" + roles] = std::strtod(value.c_str(), nullptr);
  }
  return metrics;
}

/// Corners of the triangles of a binary STL file.
std::vector<std::array<Eigen::Vector3d, 3>> ReadStl(const fs::path& path) {
  const std::string bytes = ReadTextFile(path);
  std::vector<std::array<Eigen::Vector3d, 3>> triangles;
  for (std::size_t at = 84; at + 50 <= bytes.size(); at += 50) {
    std::array<float, 9> c{};
    std::memcpy(c.data(), bytes.data() + at + 12, sizeof(c));
    triangles.push_back({Eigen::Vector3d(c[0], c[1], c[2]), Eigen::Vector3d(c[3], c[4], c[5]),
                         Eigen::Vector3d(c[6], c[7], c[8])});
  }
  return triangles;
}

/// Winding number of a closed surface about a point, by the solid angles of its triangles
/// (Van Oosterom & Strackee 1983).
bool IsInside(const std::vector<std::array<Eigen::Vector3d, 3>>& triangles,
              const Eigen::Vector3d& p) {
  double angle = 0.0;
  for (const auto& triangle : triangles) {
    const Eigen::Vector3d a = triangle[0] - p, b = triangle[1] - p, c = triangle[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                              la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la);
  }
  return std::abs(angle) > 2.0 * std::numbers::pi;
}

PoseStream Recorded(const fs::path& folder, const std::string& frame) {
  ImportOptions options;
  options.needle_frames = {};
  options.probe_frames = {frame};
  auto imported = ReadAnySession(folder, options, RunContext{});
  EXPECT_EQ(imported.probe_frame, frame);
  return imported.session.probe;
}

TEST(SlicerData, ReproducesThePublishedMetricsOfMotion) {
  FIND_OR_SKIP(folder, "sessions/perktutor_inplane");
  const auto published = PublishedMetrics(folder / "TrueMetricsTable.tsv");
  for (const auto& [frame, transform] :
       std::map<std::string, std::string>{{"NeedleTip", "NeedleTipToNeedle"},
                                          {"Needle", "NeedleToReference"},
                                          {"Image", "ImageToReference"}}) {
    const auto stream = Recorded(folder, frame);
    ASSERT_EQ(stream.size(), 222U);
    const auto metrics = training::ComputeMotionMetrics(stream);
    // Published with six digits. The issue asks for 0.1 % of the path; all digits are reached.
    const double path_mm = published.at("Path Length|Any = " + transform);
    EXPECT_NEAR(metrics.path_length_mm, path_mm, 1e-5 * path_mm) << frame;
    EXPECT_NEAR(metrics.elapsed_time_s, published.at("Elapsed Time|Any = " + transform), 5e-7);
  }
}

TEST(SlicerData, ReproducesThePublishedMetricsOfTissue) {
  FIND_OR_SKIP(folder, "sessions/perktutor_inplane");
  const auto published = PublishedMetrics(folder / "TrueMetricsTable.tsv");
  const auto triangles = ReadStl(folder / "TissueModel.stl");
  ASSERT_EQ(triangles.size(), 1560U);
  const auto inside = [&](const Eigen::Vector3d& point_mm) {
    return IsInside(triangles, point_mm);
  };
  const auto metrics = training::ComputeTissueMetrics(Recorded(folder, "NeedleTip"), inside);
  const std::string roles = "|Needle = NeedleTipToNeedle, Tissue = TissueModel";
  EXPECT_NEAR(metrics.time_in_tissue_s, published.at("Time in Tissue" + roles), 1e-6);
  EXPECT_NEAR(metrics.path_in_tissue_mm, published.at("Path in Tissue" + roles), 1e-3);
  EXPECT_NEAR(metrics.tissue_damage_mm2, published.at("Tissue Damage" + roles), 7e-3);
  EXPECT_EQ(metrics.num_insertions, 1);
}

/// As a tracker with another rate would have recorded the motion: straight between the readings.
PoseStream AtRate(const PoseStream& stream, double rate_hz) {
  PoseStream out;
  const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz);
  for (std::int64_t t = stream.front().time_ns; t <= stream.back().time_ns; t += period_ns) {
    out.push_back(PoseAt(stream, t));
    out.back().time_ns = t;
  }
  return out;
}

TEST(SlicerData, ThePublishedPathComesOutAtEveryRate) {
  FIND_OR_SKIP(folder, "sessions/perktutor_inplane");
  const auto published = PublishedMetrics(folder / "TrueMetricsTable.tsv");
  const double path_mm = published.at("Path Length|Any = NeedleTipToNeedle");
  for (const double rate_hz : {60.0, 1000.0}) {
    const PoseStream stream = AtRate(Recorded(folder, "NeedleTip"), rate_hz);
    EXPECT_NEAR(training::ComputeMotionMetrics(stream).path_length_mm, path_mm, 0.03 * path_mm)
        << rate_hz << " Hz";
  }
}

TEST(SlicerData, TakesTheNeedleTipAndTheImageByItself) {
  FIND_OR_SKIP(folder, "sessions/perktutor_inplane");
  const auto imported = ReadAnySession(folder, {}, RunContext{});
  EXPECT_EQ(imported.needle_frame, "NeedleTip");
  EXPECT_EQ(imported.probe_frame, "Image");
  ASSERT_TRUE(imported.probe_mm_per_px);
  EXPECT_NEAR(imported.probe_mm_per_px->x(), 0.1186, 1e-4);
  ASSERT_EQ(imported.session.probe.size(), imported.session.needle.size());
  ImportOptions options;
  options.face_px = Eigen::Vector2d(100, 10);
  const auto moved = ReadAnySession(folder / "Scene_InPlane.mrml", options, RunContext{});
  const Eigen::Vector3d shift =
      imported.session.probe[7].reference_from_tool.inverse() *
      Eigen::Vector3d(moved.session.probe[7].reference_from_tool.translation());
  EXPECT_LT((shift - Eigen::Vector3d(100 * imported.probe_mm_per_px->x(),
                                     10 * imported.probe_mm_per_px->y(), 0))
                .norm(),
            1e-9);
}

TEST(SlicerData, ExplainsThatABundleAloneHasNoTimes) {
  FIND_OR_SKIP(path, "sessions/perktutor_inplane/NeedleToReference-Sequence.mrb");
  EXPECT_THAT([&] { ReadAnySession(path, {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("time stamps are in it")));
}

TEST(SlicerData, SurvivesDamagedBundles) {
  FIND_OR_SKIP(folder, "sessions/perktutor_inplane");
  const testing_support::TemporaryFolder copy;
  for (const char* name : {"Scene_InPlane.mrml", "NeedleTipToNeedle.h5", "ImageToReference.h5",
                           "NeedleToReference.h5", "ImageToReference-Sequence.mrb"}) {
    fs::copy_file(folder / name, copy / name);
  }
  const std::string name = "NeedleToReference-Sequence.mrb";
  const int refused =
      testing_support::ReadDamagedCopies(ReadTextFile(folder / name), copy / name, 40,
                                         [&] { ReadAnySession(copy.path(), {}, RunContext{}); });
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace acus::session
