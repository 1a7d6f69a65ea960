#include "acus/data/session/recording_import.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/column_csv.h"
#include "acus/data/session/frame_guess.h"
#include "acus/data/session/perk_buffer.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

std::string Translation(double x) {
  return "1 0 0 " + std::to_string(x) + " 0 1 0 2 0 0 1 3 0 0 0 1";
}

/// A PLUS sequence of images without pixels, of three frames.
std::string Sequence(const std::string& transform, bool has_times) {
  std::string text =
      "ObjectType = Image\nNDims = 3\nDimSize = 0 0 3\nElementType = MET_UCHAR\n"
      "ElementNumberOfChannels = 1\nCompressedData = False\nBinaryData = True\n";
  for (int i = 0; i < 3; ++i) {
    const std::string frame = "Seq_Frame000" + std::to_string(i) + "_";
    text += frame + transform + "Transform = " + Translation(i) + "\n";
    text += frame + transform + "TransformStatus = OK\n";
    if (has_times) text += frame + "Timestamp = " + std::to_string(5 + i) + "\n";
  }
  return text + "ElementDataFile = LOCAL\n";
}

/// A recording's warnings, as one text.
ImportedSession Import(const std::filesystem::path& path, const RecordingOptions& options,
                       std::string& warnings) {
  RunContext context;
  context.on_warning = [&](std::string_view text) { warnings += text; };
  return ImportRecording(path, options, context);
}

TEST(ImportRecording, InventsTimesOnlyIfRequested) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "a.igs.mha", Sequence("ProbeToReference", false));
  EXPECT_THAT([&] { ImportRecording(folder / "a.igs.mha", {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("--frame-rate-hz")));
  const auto made = ImportRecording(folder / "a.igs.mha", {.frame_rate_hz = 20.0}, RunContext{});
  ASSERT_EQ(made.session.probe.size(), 3U);
  EXPECT_EQ(made.session.probe[2].time_ns, 100'000'000);
  WriteTextFile(folder / "b.igs.mha", Sequence("ProbeToReference", true));
  const auto own = ImportRecording(folder / "b.igs.mha", {.frame_rate_hz = 20.0}, RunContext{});
  EXPECT_EQ(own.session.probe[2].time_ns, 7'000'000'000);  // Its own times stay.
}

TEST(ImportRecording, TakesTheFramesThatAreThereAndSaysSo) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "a.igs.mha", Sequence("ProbeToStepperHome", true));
  std::string warnings;
  const auto found = Import(folder / "a.igs.mha", {}, warnings);
  EXPECT_EQ(found.probe_frame, "Probe");
  EXPECT_EQ(found.session.reference_frame, "StepperHome");
  EXPECT_EQ(found.session.probe[1].reference_from_tool.translation().x(), 1.0);
  EXPECT_THAT(warnings, HasSubstr("poses are taken in StepperHome"));
  EXPECT_THAT(ImportReport(found), HasSubstr("needle: none"));
  EXPECT_THAT(ImportReport(found), HasSubstr("probe: frame Probe, 3 samples in 2 s (1 Hz)"));
  // A frame that the user named is not replaced by another.
  EXPECT_THAT(
      [&] {
        ImportRecording(folder / "a.igs.mha", {.frames = {.reference_frame = "Table"}},
                        RunContext{});
      },
      ThrowsMessage<InputError>(HasSubstr("--needle, --probe and --reference")));
}

TEST(GuessFrames, PrefersUsualNames) {
  const auto guess = GuessFrames({{"MyNeedle", "Tracker"}, {"UsProbe", "Tracker"}, {"A", "B"}});
  ASSERT_TRUE(guess);
  EXPECT_EQ(guess->reference, "Tracker");
  EXPECT_THAT(guess->needle, ElementsAre("MyNeedle"));
  EXPECT_THAT(guess->probe, ElementsAre("UsProbe"));
  EXPECT_THAT(GuessFrames({{"Tool", "Tracker"}})->needle, ElementsAre("Tool"));
  EXPECT_FALSE(GuessFrames({}));
}

std::string Log(int seconds, int nanoseconds, const std::string& device, double x) {
  return "<log TimeStampSec=\"" + std::to_string(seconds) + "\" TimeStampNSec=\"" +
         std::to_string(nanoseconds) + "\" type=\"transform\" DeviceName=\"" + device +
         "\" transform=\"" + Translation(x) + " \" />\n";
}

TEST(PerkBuffer, IsSampledAsPerkTutorDoes) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "buffer.xml",
                "<TransformRecorderLog>\n" + Log(7, 256000000, "ProbeToRAS", 1) +
                    Log(7, 256900000, "StylusTipToRAS", 10) +  // Within 1 ms: of the same time.
                    Log(7, 300000000, "ProbeToRAS", 2) + Log(7, 305000000, "StylusTipToRAS", 20) +
                    Log(7, 400000000, "ProbeToRAS", 3) +
                    "<log TimeStampSec=\"8\" TimeStampNSec=\"0\" type=\"message\" message=\"end\"/>"
                    "</TransformRecorderLog>");
  const auto scene = ReadPerkBuffer(folder / "buffer.xml");
  const auto& stylus = scene.sequences.at("StylusTipToRAS");
  ASSERT_EQ(stylus.size(), 3U);
  EXPECT_EQ(stylus[1].time_ns, 7'300'000'000);
  EXPECT_EQ(stylus[0].to_from_from(0, 3), 10.0);
  EXPECT_EQ(stylus[1].to_from_from(0, 3), 10.0);  // The last before.
  EXPECT_EQ(stylus[2].to_from_from(0, 3), 20.0);
  std::string warnings;
  const auto found = Import(folder / "buffer.xml", {}, warnings);
  EXPECT_EQ(found.needle_frame, "StylusTip");
  EXPECT_EQ(found.probe_frame, "Probe");
  EXPECT_EQ(found.session.reference_frame, "RAS");
  WriteTextFile(folder / "other.xml", "<PlusConfiguration/>");
  EXPECT_THAT([&] { ReadPerkBuffer(folder / "other.xml"); },
              ThrowsMessage<InputError>(HasSubstr("TransformRecorderLog")));
  WriteTextFile(folder / "bad.xml",
                "<TransformRecorderLog><log TimeStampSec=\"x\" type=\"transform\""
                " DeviceName=\"AToB\" transform=\"1 2\"/></TransformRecorderLog>");
  EXPECT_THAT([&] { ReadPerkBuffer(folder / "bad.xml"); },
              ThrowsMessage<InputError>(HasSubstr("not 16 finite numbers")));
}

TEST(ColumnCsv, ReadsAnExportOfMotive) {
  const TemporaryFolder folder;
  WriteTextFile(
      folder / "take.csv",
      "Format Version,1.23,Take Name,a\n\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
      ",Name,Needle,Needle,Needle,Needle,Needle,Needle,Needle\n"
      ",ID,1,1,1,1,1,1,1\n"
      ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n"
      "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z\n"
      "0,0.000000,0,0,0,1,0.1,0.2,0.3\r\n"
      "1,0.010000,,,,,,,\n"
      "2,0.020000,0,0,1,0,0.1,0.2,0.4\n");
  WriteTextFile(
      folder / "map.json",
      R"json({"format": "acus-columns/1", "name": "m", "header_rows": [4, 6, 7], "first_row": 8,
    "length_unit": "m", "time": {"column": "Name/Time (Seconds)"}, "tools": [{"tool": "needle",
      "position": ["Needle/Position/X", "Needle/Position/Y", "Needle/Position/Z"],
      "rotation": ["Needle/Rotation/W", "Needle/Rotation/X", "Needle/Rotation/Y",
                   "Needle/Rotation/Z"]}]})json");
  const auto found =
      ImportRecording(folder / "take.csv", {.columns = folder / "map.json"}, RunContext{});
  ASSERT_EQ(found.session.needle.size(), 3U);
  EXPECT_EQ(found.session.needle[1].time_ns, 10'000'000);
  EXPECT_FALSE(found.session.needle[1].valid);
  EXPECT_LT(
      (found.session.needle[2].reference_from_tool.translation() - Eigen::Vector3d(100, 200, 400))
          .norm(),
      1e-9);
  EXPECT_THAT([&] { ImportRecording(folder / "take.csv", {}, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("--columns")));
}

std::filesystem::path Preset(const char* name) {
  return std::filesystem::path(ACUS_SOURCE_DIR) / "configs/columns" / name;
}

TEST(ColumnCsv, UsesTheUnitThatTheFileDeclares) {
  const TemporaryFolder folder;
  const std::string head = "Format Version,1.25,Length Units,Millimeters\n";
  const std::string names = "time,x,y,z,w,a,b,c\n";
  WriteTextFile(folder / "mm.csv", head + names + "0,5,10,60,1,0,0,0\n1,5,10,59,1,0,0,0\n");
  WriteTextFile(folder / "map.json",
                R"json({"format": "acus-columns/1", "name": "m", "header_rows": [2],
    "first_row": 3, "length_unit": "m", "time": {"column": "time"}, "tools": [{"tool": "needle",
      "position": ["x", "y", "z"], "rotation": ["w", "a", "b", "c"]}]})json");
  std::string warnings;
  const auto found = Import(folder / "mm.csv", {.columns = folder / "map.json"}, warnings);
  EXPECT_EQ(found.session.needle.back().reference_from_tool.translation().z(), 59.0);
  EXPECT_THAT(warnings, HasSubstr("length units are Millimeters"));
  // Without the declaration, the mapping puts the needle 60 m away.
  WriteTextFile(folder / "mm.csv", "\n" + names + "0,5,10,60,1,0,0,0\n1,5,10,59,1,0,0,0\n");
  const auto import = [&](bool as_it_is) {
    return ImportRecording(folder / "mm.csv",
                           {.columns = folder / "map.json", .as_it_is = as_it_is}, RunContext{});
  };
  EXPECT_THAT([&] { import(false); }, ThrowsMessage<InputError>(HasSubstr("probably in mm")));
  EXPECT_EQ(import(true).session.needle.size(), 2U);
}

TEST(ColumnCsv, ReadsPosesBetweenBlanks) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "a.txt",
                "# timestamp tx ty tz qx qy qz qw\n"
                "1714557700.25 0.005 0.01 0.06 0 0 0 1\n1714557700.25 0.005 0.01 0.06 0 0 0 1\n"
                "1714557700.30 0.005 0.01 0.059 0 0 0 1\n");
  std::string warnings;
  const auto found = Import(folder / "a.txt", {.columns = Preset("tum.json")}, warnings);
  ASSERT_EQ(found.session.needle.size(), 2U);
  EXPECT_NEAR(found.session.needle[1].reference_from_tool.translation().z(), 59.0, 1e-9);
  EXPECT_THAT(warnings, HasSubstr("1 row with the time of the row before"));
}

TEST(ColumnCsv, NamesTheColumnsThereAre) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "ndi.csv",
                "Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n"
                "60,OK,1,0,0,0,1,2,3\n61,Missing,1,0,0,0,9,9,9\n");
  const std::filesystem::path preset =
      std::filesystem::path(ACUS_SOURCE_DIR) / "configs/columns/ndi_toolbox.json";
  const auto session = ReadColumnCsv(folder / "ndi.csv", preset, false, RunContext{});
  EXPECT_EQ(session.needle.front().time_ns, 1'000'000'000);
  EXPECT_FALSE(session.needle.back().valid);
  WriteTextFile(folder / "other.csv", "Frame,State,A\n1,OK,2\n");
  EXPECT_THAT([&] { ReadColumnCsv(folder / "other.csv", preset, false, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("has no column 'Tx'; change the mapping "
                                                  "(--columns); there are: Frame, State, A")));
  WriteTextFile(folder / "back.csv",
                "Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n"
                "60,OK,1,0,0,0,1,2,3\n59,OK,1,0,0,0,1,2,3\n");
  EXPECT_THAT([&] { ReadColumnCsv(folder / "back.csv", preset, false, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("back.csv:3: its time does not increase")));
}

}  // namespace
}  // namespace acus::session
