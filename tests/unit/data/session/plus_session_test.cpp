#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/xml_scan.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/sequence_writer.h"
#include "acus/data/session/session_import.h"
#include "acus/data/session/session_io.h"
#include "acus/data/session/tool_stream.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

Eigen::Isometry3d ProbeAt(int i) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d(1, 2, 2) / 3.0));
  pose.translation() << 100.0 + i, 20.0, -5.0 * i;
  return pose;
}

Eigen::Isometry3d ReferenceAt(int i) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(2.0 - 0.01 * i, Eigen::Vector3d::UnitY()));
  pose.translation() << -30.0, 7.0 * i, 250.0;
  return pose;
}

/// What PLUS records: a probe and a reference that both move in front of the tracker. In frame 2
/// the reference is not seen.
void WriteRecording(const fs::path& path, const std::map<std::string, std::string>& fields = {}) {
  SequenceFormat format;
  format.fields = fields;
  SequenceWriter writer(path, format);
  for (int i = 0; i < 5; ++i) {
    SequenceFields frame;
    AddTransform(frame, "ProbeToTracker", ProbeAt(i).matrix(), true);
    AddTransform(frame, "ReferenceToTracker", ReferenceAt(i).matrix(), i != 2);
    writer.AddFrame(1'000'000'000 + std::int64_t{i} * 50'000'000, {}, frame);
  }
  writer.Commit();
}

ImportOptions ProbeOnly(const std::string& frame) {
  ImportOptions options;
  options.needle_frames = {};
  options.probe_frames = {frame};
  return options;
}

TEST(PlusSession, GivesToolsInTheReferenceFrame) {
  const TemporaryFolder folder;
  WriteRecording(folder / "a.igs.mha");
  const auto imported = ReadAnySession(folder / "a.igs.mha", {}, RunContext{});
  EXPECT_EQ(imported.probe_frame, "Probe");
  EXPECT_EQ(imported.needle_frame, "");
  EXPECT_FALSE(imported.probe_mm_per_px);
  EXPECT_TRUE(imported.session.needle.empty());
  const PoseStream& probe = imported.session.probe;
  ASSERT_EQ(probe.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(probe[i].time_ns, 1'000'000'000 + std::int64_t{i} * 50'000'000);
    EXPECT_EQ(probe[i].valid, i != 2);
    const Eigen::Isometry3d truth = ReferenceAt(i).inverse() * ProbeAt(i);
    if (i == 2) continue;
    EXPECT_LT((probe[i].reference_from_tool.matrix() - truth.matrix()).norm(), 1e-12) << i;
  }
  EXPECT_EQ(probe[2].reference_from_tool, probe[1].reference_from_tool);
}

TEST(PlusSession, CanBeKeptAsASessionFolder) {
  const TemporaryFolder folder;
  WriteRecording(folder / "a.igs.mha");
  const auto imported = ReadAnySession(folder / "a.igs.mha", {}, RunContext{});
  WriteSession(folder / "session", imported.session, RunContext{});
  const auto again = ReadAnySession(folder / "session", {}, RunContext{});
  EXPECT_EQ(again.probe_frame, "probe");
  ASSERT_EQ(again.session.probe.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(again.session.probe[i].reference_from_tool,
              imported.session.probe[i].reference_from_tool);
  }
}

TEST(PlusSession, TakesAnImageFrameApartIntoPoseAndPixels) {
  const TemporaryFolder folder;
  Eigen::Isometry3d probe_from_image(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  probe_from_image.translation() << 3, 4, 5;
  const Eigen::Matrix4d scaled =
      probe_from_image.matrix() * Eigen::Vector4d(0.2, 0.1, 0.2, 1).asDiagonal();
  WriteRecording(folder / "a.igs.mha", {{"ImageToProbeTransform", TransformText(scaled)}});
  ImportOptions options = ProbeOnly("Image");
  const auto corner = ReadPlusSession(folder / "a.igs.mha", options, RunContext{});
  ASSERT_TRUE(corner.probe_mm_per_px);
  EXPECT_LT((*corner.probe_mm_per_px - Eigen::Vector2d(0.2, 0.1)).norm(), 1e-12);
  options.face_px = Eigen::Vector2d(50, 10);
  const auto face = ReadPlusSession(folder / "a.igs.mha", options, RunContext{});
  const Eigen::Isometry3d reference_from_image =
      ReferenceAt(3).inverse() * ProbeAt(3) * probe_from_image;
  EXPECT_LT(
      (corner.session.probe[3].reference_from_tool.matrix() - reference_from_image.matrix()).norm(),
      1e-12);
  EXPECT_LT((face.session.probe[3].reference_from_tool.translation() -
             reference_from_image * Eigen::Vector3d(10, 1, 0))
                .norm(),
            1e-12);
}

TEST(PlusSession, NamesTheTransformsThereAreIfNoneFits) {
  const TemporaryFolder folder;
  WriteRecording(folder / "a.igs.mha");
  EXPECT_THAT([&] { ReadPlusSession(folder / "a.igs.mha", ProbeOnly("Hand"), RunContext{}); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("none of the frames"), HasSubstr("Hand"),
                                              HasSubstr("ProbeToTracker, ReferenceToTracker"))));
  ImportOptions options;
  options.reference_frame = "Table";
  EXPECT_THAT([&] { ReadPlusSession(folder / "a.igs.mha", options, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("is connected with Table")));
  options = ProbeOnly("Probe");
  options.calibrations["Nonsense"] = Eigen::Matrix4d::Identity();
  EXPECT_THAT([&] { ReadPlusSession(folder / "a.igs.mha", options, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("calibration 'Nonsense'")));
}

TEST(ReadAnySession, SaysWhatItReads) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "poses.txt", "1 2 3");
  EXPECT_THAT([&] { ReadAnySession(folder / "poses.txt", {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("'acus-import --columns MAPPING' reads it")));
  WriteTextFile(folder / "poses.pdf", "1 2 3");
  EXPECT_THAT([&] { ReadAnySession(folder / "poses.pdf", {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("allowed: a session folder")));
  EXPECT_THAT([&] { ReadAnySession(folder / "none", {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("no such file")));
  EXPECT_THAT([&] { ReadAnySession(folder.path(), {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("neither session.json nor a Slicer scene")));
}

transforms::TransformGraph Graph(const Eigen::Matrix4d& reference_from_tool) {
  transforms::TransformGraph graph;
  graph.Set({"Tool", "Reference"}, reference_from_tool, true);
  return graph;
}

std::optional<ToolStream> ExtractFrom(const std::vector<TimedTransforms>& instants,
                                      std::vector<std::string>* warnings = nullptr) {
  RunContext context;
  context.on_warning = [&](std::string_view text) {
    if (warnings != nullptr) warnings->emplace_back(text);
  };
  const std::vector<std::string> frames = {"Elsewhere", "Tool"};
  return ExtractTool(instants, frames, "Reference", "a.igs.mha", context);
}

TEST(ExtractTool, LeavesOutRepeatedStampsAndRefusesTimeThatGoesBack) {
  const Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  std::vector<std::string> warnings;
  const auto tool = ExtractFrom({{0, Graph(pose)}, {5, Graph(pose)}, {5, Graph(pose)}}, &warnings);
  EXPECT_EQ(tool->poses.size(), 2U);
  EXPECT_EQ(tool->frame, "Tool");
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("1 frames repeat the time stamp")));
  EXPECT_THAT(
      [&] {
        ExtractFrom({{5, Graph(pose)}, {4, Graph(pose)}});
      },
      ThrowsMessage<InputError>(HasSubstr("a.igs.mha: frame 1: time goes back from "
                                          "0.000000005 s to 0.000000004 s")));
}

TEST(ExtractTool, MarksInstantsWithoutAConnectionInvalid) {
  const Eigen::Matrix4d pose = ProbeAt(1).matrix();
  const auto tool = ExtractFrom({{0, {}}, {1, Graph(pose)}, {2, {}}});
  ASSERT_EQ(tool->poses.size(), 3U);
  EXPECT_FALSE(tool->poses[0].valid);
  EXPECT_TRUE(tool->poses[1].valid);
  EXPECT_FALSE(tool->poses[2].valid);
  EXPECT_EQ(tool->poses[0].reference_from_tool, tool->poses[1].reference_from_tool);
  EXPECT_FALSE(ExtractFrom({{0, {}}, {1, {}}}));
}

TEST(ExtractTool, RefusesWhatIsNotAPose) {
  const Eigen::Matrix4d mirror = Eigen::Vector4d(1, 1, -1, 1).asDiagonal();
  EXPECT_THAT(
      [&] {
        ExtractFrom({{0, Graph(mirror)}});
      },
      ThrowsMessage<InputError>(HasSubstr("frame 0: ToolToReference is not a pose")));
  const Eigen::Matrix4d bigger = Eigen::Vector4d(1.011, 1, 1, 1).asDiagonal();
  EXPECT_THAT(
      [&] {
        ExtractFrom({{0, Graph(Eigen::Matrix4d::Identity())}, {1, Graph(bigger)}});
      },
      ThrowsMessage<InputError>(HasSubstr("frame 1: ToolToReference changes its scale")));
}

constexpr const char* kConfig = R"(<?xml version="1.0"?>
<PlusConfiguration version="2.1">
  <!-- <Transform From="A" To="B" Matrix="rubbish"/> -->
  <DataCollection><Message Type='TRANSFORM &amp; IMAGE' /></DataCollection>
  <CoordinateDefinitions>
    <Transform From="Image" To="Probe"
      Matrix="
        0.1 0 0 5
        0 0.2 0 6
        0 0 0.1 7
        0 0 0 1" Error="0.58" />
    <Transform Name="ProbeToReference" />
  </CoordinateDefinitions>
</PlusConfiguration>
)";

TEST(PlusConfig, GivesTheCoordinateDefinitions) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "a.xml", kConfig);
  const auto calibrations = ReadPlusCalibrations(folder / "a.xml");
  ASSERT_EQ(calibrations.size(), 1U);
  Eigen::Matrix4d expected = Eigen::Vector4d(0.1, 0.2, 0.1, 1).asDiagonal();
  expected.topRightCorner<3, 1>() << 5, 6, 7;
  EXPECT_EQ(calibrations.at("ImageToProbe"), expected);
}

TEST(PlusConfig, RefusesOtherFilesAndDamagedOnes) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    WriteTextFile(folder / "a.xml", text);
    return [&] { ReadPlusCalibrations(folder / "a.xml"); };
  };
  EXPECT_THAT(read("<html/>"), ThrowsMessage<InputError>(HasSubstr("its first element is 'html'")));
  std::string short_matrix = kConfig;
  short_matrix.erase(short_matrix.find("0 0 0 1\""), 2);
  EXPECT_THAT(read(short_matrix), ThrowsMessage<InputError>(HasSubstr("matrix of ImageToProbe")));
  const int refused = testing_support::ReadDamagedCopies(
      kConfig, folder / "a.xml", 400, [&] { ReadPlusCalibrations(folder / "a.xml"); });
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace acus::session
