#include <cstring>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/sequence_writer.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Files of the running test, gone after it.
class SequenceTest : public testing::Test {
 protected:
  fs::path Temporary(const std::string& name) const { return folder_ / name; }

  testing_support::TemporaryFolder folder_;
};

std::vector<std::uint8_t> NoisyImage(std::size_t size, std::uint64_t frame) {
  RandomStream random(11, "image", frame);
  std::vector<std::uint8_t> image(size);
  for (auto& pixel : image) pixel = static_cast<std::uint8_t>(random.Next() % 32);
  return image;
}

Eigen::Matrix4d PoseOf(std::size_t frame) {
  Eigen::Isometry3d pose(
      Eigen::AngleAxisd(0.1 * static_cast<double>(frame), Eigen::Vector3d(1, 2, 3).normalized()));
  pose.translation() << 1.0 / 3.0, static_cast<double>(frame), -1e-5;
  return pose.matrix();
}

void SequenceWriteExample(const fs::path& path, const SequenceFormat& format,
                          std::size_t num_frames) {
  SequenceWriter writer(path, format);
  for (std::size_t i = 0; i < num_frames; ++i) {
    SequenceFields fields;
    AddTransform(fields, "ProbeToReference", PoseOf(i), i != 2);
    fields.emplace_back("ForceN", "0.25");
    fields.emplace_back("Note", "");
    writer.AddFrame(1'000'000'000 + static_cast<std::int64_t>(i) * 33'333'333,
                    NoisyImage(format.width * format.height * format.channels, i), fields);
  }
  writer.Commit();
}

struct Case {
  const char* name;
  bool compressed;
  std::size_t channels;
};

class SequenceWriterTest : public SequenceTest {};

class SequenceRoundTrip : public SequenceTest, public testing::WithParamInterface<Case> {};

TEST_P(SequenceRoundTrip, KeepsEveryPixelPoseAndStamp) {
  const fs::path path = Temporary(GetParam().name);
  SequenceFormat format{.width = 31, .height = 17, .channels = GetParam().channels};
  format.compressed = GetParam().compressed;
  format.fields["ImageToProbeTransform"] = TransformText(PoseOf(9));
  SequenceWriteExample(path, format, 5);
  SequenceFile file(path);
  ASSERT_EQ(file.num_frames(), 5U);
  EXPECT_EQ(file.header().width, 31U);
  EXPECT_EQ(file.header().height, 17U);
  EXPECT_EQ(file.header().channels, GetParam().channels);
  EXPECT_EQ(file.Orientation(), "MFA");
  for (const std::size_t i : {0U, 1U, 4U, 3U, 2U, 2U}) {  // Also backwards.
    EXPECT_EQ(file.ReadImage(i), NoisyImage(31 * 17 * GetParam().channels, i)) << i;
    EXPECT_EQ(file.TimeNs(i), 1'000'000'000 + static_cast<std::int64_t>(i) * 33'333'333);
    const auto pose = file.Transforms(i).Find("Probe", "Reference");
    EXPECT_EQ(pose->to_from_from, PoseOf(i));
    EXPECT_EQ(pose->valid, i != 2);
    EXPECT_EQ(file.Transforms(i).Find("Image", "Probe")->to_from_from, PoseOf(9));
    EXPECT_EQ(file.header().Field(i, "ForceN"), "0.25");
    EXPECT_EQ(file.header().Field(i, "Note"), "");
    EXPECT_EQ(file.header().Field(i, "ImageStatus"), "OK");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Formats, SequenceRoundTrip,
    testing::Values(Case{"raw.igs.mha", false, 1}, Case{"zlib.igs.mha", true, 1},
                    Case{"raw.igs.nrrd", false, 1}, Case{"gzip.igs.nrrd", true, 1},
                    Case{"rgb.igs.mha", true, 3}, Case{"rgb.igs.nrrd", false, 3}),
    [](const auto& param) {
      std::string name = param.param.name;
      std::ranges::replace(name, '.', '_');
      return name;
    });

TEST_F(SequenceWriterTest, BeginsAndEndsTheHeaderAsPlusExpects) {
  const fs::path path = Temporary("header.igs.mha");
  SequenceWriteExample(path, {.width = 4, .height = 3}, 2);
  const std::string text = ReadTextFile(path);
  EXPECT_TRUE(text.starts_with("ObjectType = Image\nNDims = 3\n"));
  const std::string end = "ElementDataFile = LOCAL\n";
  EXPECT_EQ(text.find(end) + end.size() + 2 * 4 * 3, text.size());
  EXPECT_THAT(text, HasSubstr("\nDimSize = 4 3 2\n"));
  EXPECT_THAT(text, HasSubstr("\nSeq_Frame0001_ProbeToReferenceTransformStatus = OK\n"));
  EXPECT_THAT(text, HasSubstr("\nSeq_Frame0001_Timestamp = 1.033333333\n"));
}

TEST_F(SequenceWriterTest, WidensTheNumberBeyond9999Frames) {
  const fs::path path = Temporary("long.igs.mha");
  SequenceWriteExample(path, {}, 10'002);
  SequenceFile file(path);
  ASSERT_EQ(file.num_frames(), 10'002U);
  EXPECT_FALSE(file.has_images());
  EXPECT_EQ(file.header().pixel_type, PixelType::kNone);
  EXPECT_EQ(file.Transforms(10'001).Find("Probe", "Reference")->to_from_from, PoseOf(10'001));
  EXPECT_THAT(ReadTextFile(path), HasSubstr("Seq_Frame10001_Timestamp"));
  EXPECT_THAT([&] { file.ReadImage(0); }, ThrowsMessage<InputError>(HasSubstr("without images")));
}

TEST_F(SequenceWriterTest, LeavesNothingBehindWithoutCommit) {
  const fs::path folder = Temporary("writer_dropped");
  fs::remove_all(folder);
  {
    SequenceWriter writer(folder / "a.igs.mha", {.width = 2, .height = 2});
    writer.AddFrame(0, NoisyImage(4, 0), {});
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(SequenceWriterTest, RefusesWhatWouldNotReadBack) {
  EXPECT_THAT([&] { SequenceWriter(Temporary("a.png"), {}); },
              ThrowsMessage<InputError>(HasSubstr("must be .igs.mha or .igs.nrrd")));
  EXPECT_THAT([&] { SequenceWriter(Temporary("a.igs.nrrd"), {}); },
              ThrowsMessage<InputError>(HasSubstr("NRRD cannot hold")));
  EXPECT_THROW(SequenceWriter(Temporary("a.igs.mha"), {.width = 3}), InputError);
  EXPECT_THROW(SequenceWriter(Temporary("a.igs.mha"), {.width = 3, .height = 3, .channels = 5}),
               InputError);
  SequenceWriter writer(Temporary("a.igs.mha"), {.width = 2, .height = 2});
  EXPECT_THAT([&] { writer.Commit(); }, ThrowsMessage<InputError>(HasSubstr("without a frame")));
  EXPECT_THAT([&] { writer.AddFrame(0, NoisyImage(5, 0), {}); },
              ThrowsMessage<InputError>(HasSubstr("5 bytes instead of 4")));
  EXPECT_THAT(
      [&] {
        writer.AddFrame(0, {}, {{"A", "two\nlines"}});
      },
      ThrowsMessage<InputError>(HasSubstr("one line")));
  EXPECT_THROW(writer.AddFrame(0, {}, {{"A B", "x"}}), InputError);
  EXPECT_THROW(writer.AddFrame(0, {}, {{"A", std::string(1000, 'x')}}), InputError);
  writer.AddFrame(5, NoisyImage(4, 0), {});
  EXPECT_THAT([&] { writer.AddFrame(5, NoisyImage(4, 0), {}); },
              ThrowsMessage<InputError>(HasSubstr("not later")));
  SequenceFields fields;
  EXPECT_THROW(AddTransform(fields, "Probe", Eigen::Matrix4d::Identity(), true), InputError);
}

std::string Header(const std::string& lines) {
  return "ObjectType = Image\nNDims = 3\n" + lines;
}

class SequenceFileTest : public SequenceTest {
 protected:
  /// A file of 3 x 2 pixels with the values 0 to 5.
  fs::path Oriented(const std::string& orientation, bool as_int16) const {
    std::string text = Header(
        "DimSize = 3 2 1\nElementType = " + std::string(as_int16 ? "MET_SHORT" : "MET_UCHAR") +
        "\nElementByteOrderMSB = True\nUltrasoundImageOrientation = " + orientation +
        "\nSeq_Frame0000_Timestamp = 0\nElementDataFile = LOCAL\n");
    for (int i = 0; i < 6; ++i) {
      if (as_int16) text += '\1';  // Big-endian: 256 + i.
      text += static_cast<char>(i);
    }
    const fs::path path = Temporary("oriented.igs.mha");
    WriteTextFile(path, text);
    return path;
  }
};

TEST_F(SequenceFileTest, TurnsImagesToMarkedAndFar) {
  const auto turned = [&](const std::string& orientation) {
    SequenceFile file(Oriented(orientation, false));
    const auto image = file.ReadImageMarkedFar(0);
    std::string text = std::to_string(image.width) + ":";
    for (const auto pixel : image.pixels) text += std::to_string(pixel);
    return text;
  };
  EXPECT_EQ(turned("MF"), "3:012345");
  EXPECT_EQ(turned("MFA"), "3:012345");
  EXPECT_EQ(turned("UFA"), "3:210543");
  EXPECT_EQ(turned("MN"), "3:345012");
  EXPECT_EQ(turned("UN"), "3:543210");
  EXPECT_EQ(turned("FM"), "2:031425");  // Each stored row is a scan line.
  EXPECT_EQ(turned("NU"), "2:524130");
  EXPECT_THAT([&] { turned("XX"); }, ThrowsMessage<InputError>(HasSubstr("is 'XX'")));
  EXPECT_THAT([&] { turned("MM"); }, ThrowsMessage<InputError>(HasSubstr("is 'MM'")));
}

TEST_F(SequenceFileTest, GivesBigEndianNumbersInOurByteOrder) {
  SequenceFile file(Oriented("FM", true));
  const auto bytes = file.ReadImage(0);
  std::array<std::int16_t, 6> values{};
  std::memcpy(values.data(), bytes.data(), sizeof(values));
  EXPECT_THAT(values, testing::ElementsAre(256, 257, 258, 259, 260, 261));
  const auto image = file.ReadImageMarkedFar(0);
  std::memcpy(values.data(), image.pixels.data(), sizeof(values));
  EXPECT_THAT(values, testing::ElementsAre(256, 259, 257, 260, 258, 261));
}

TEST_F(SequenceFileTest, NamesFileLineAndRemedy) {
  const auto read = [&](const std::string& text) {
    const fs::path path = Temporary("bad.igs.mha");
    WriteTextFile(path, text);
    return [path] { SequenceFile file(path); };
  };
  const auto expect = [&](const std::string& text, const char* message) {
    EXPECT_THAT(read(text), ThrowsMessage<InputError>(HasSubstr(message))) << text;
  };
  const std::string type = "ElementType = MET_UCHAR\n";
  const std::string local = "ElementDataFile = LOCAL\n";
  expect("", "is empty");
  expect("\x89PNG\r\n", "is not a sequence file");
  expect(Header("DimSize = 2 2 1\n"), "header ends early");
  expect(Header("DimSize = 2 2\n" + type), "the header ends early");
  expect(Header("DimSize = 2 -2 1\n"), ":3: the size");
  expect(Header("DimSize = 2 2 0\n"), ":3: the size");
  expect(Header("DimSize = 70000 2 1\n"), ":3: the size");
  expect(Header("ElementType = MET_STRING\n"), "'MET_STRING'");
  expect(Header("ElementNumberOfChannels = 0\n"), "1 to 4");
  expect(Header("ElementNumberOfChannels = 5\n"), "1 to 4");
  expect(Header("BinaryData = False\n"), "written as text");
  expect(Header("CompressedData = Yes\n"), "'Yes'");
  expect(Header("rubbish\n"), "'name = value'");
  expect(Header("Seq_FrameXX_Timestamp = 0\n"), "Seq_FrameXX_Timestamp");
  expect(Header("Seq_Frame0000_A = 0\nSeq_Frame0000_A = 1\n"), "given twice");
  expect(Header("Seq_Frame99999_A = 0\n"), "cannot be in a file");
  expect(Header(type + local), "no DimSize");
  expect(Header("DimSize = 2 2 1\n" + local + "abcd"), "no type");
  expect(Header("DimSize = 2 2 1\n" + type + local + "abc"), "only 3 bytes are there");
  expect(Header("DimSize = 60000 60000 1\n" + type + local), "at most 1073741824");
  expect(Header("DimSize = 2 2 900000\n" + type + local + "abcd"), "cut off");
  expect(Header("DimSize = 2 2 9000000\n" + type + local + "abcd"), "declares 9000000 frames");
  expect(Header("DimSize = 2 2 1\nSeq_Frame0003_A = 0\n" + type + local + "abcd"),
         "fields of frame 3");
  expect(Header("DimSize = 2 2 2\nSeq_Frame0000_A = 0\n" + type + local + "abcdabcd"),
         "only 1 are there");
  expect(Header("ElementDataFile = ../other.raw\n"), "beside this one");
  expect(Header(std::string(70000, 'x')), "longer than 65536");
}

TEST_F(SequenceFileTest, ReadsPosesWithoutTheFileOfPixels) {
  const fs::path path = Temporary("missing.igs.mhd");
  WriteTextFile(path, Header("DimSize = 2 2 1\nElementType = MET_UCHAR\n"
                             "Seq_Frame0000_AToBTransform = 1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1 \n"
                             "ElementDataFile = nowhere.raw\n"));
  SequenceFile file(path);
  EXPECT_EQ(file.Transforms(0).Find("A", "B")->to_from_from(1, 3), 6.0);
  EXPECT_EQ(file.TimeNs(0), std::nullopt);
  EXPECT_THAT([&] { file.ReadImage(0); }, ThrowsMessage<InputError>(HasSubstr("nowhere.raw")));
  WriteTextFile(Temporary("nowhere.raw"), "abcd");
  EXPECT_EQ(SequenceFile(path).ReadImage(0), (std::vector<std::uint8_t>{'a', 'b', 'c', 'd'}));
}

TEST_F(SequenceFileTest, RefusesAValidTransformThatIsNotSixteenNumbers) {
  const auto transforms = [&](const std::string& value, const std::string& status) {
    const fs::path path = Temporary("transform.igs.mha");
    WriteTextFile(path, Header("DimSize = 0 0 1\nElementType = MET_OTHER\n"
                               "Seq_Frame0000_AToBTransform = " +
                               value + "\nSeq_Frame0000_AToBTransformStatus = " + status +
                               "\nElementDataFile = LOCAL\n"));
    return SequenceFile(path).Transforms(0);
  };
  EXPECT_THAT([&] { transforms("1 0 0", "OK"); },
              ThrowsMessage<InputError>(HasSubstr("frame 0: AToBTransform is '1 0 0'")));
  EXPECT_THAT([&] { transforms("nan 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1", "OK"); },
              ThrowsMessage<InputError>(HasSubstr("16 finite numbers")));
  EXPECT_FALSE(transforms("nan", "MISSING").Find("A", "B")->valid);
  EXPECT_FALSE(transforms("1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1", "OUT_OF_VIEW").Find("A", "B")->valid);
}

TEST_F(SequenceFileTest, ReportsABrokenCompression) {
  const fs::path path = Temporary("zlib_broken.igs.mha");
  SequenceWriteExample(path, {.width = 64, .height = 64, .compressed = true}, 3);
  std::string text = ReadTextFile(path);
  for (std::size_t i = text.size() - 3000; i < text.size(); ++i)
    text[i] = static_cast<char>(~text[i]);
  WriteTextFile(path, text);
  SequenceFile file(path);
  EXPECT_THAT([&] { file.ReadImage(2); }, ThrowsMessage<InputError>(HasSubstr("damaged")));
}

TEST_F(SequenceFileTest, HoldsTheImagesAgainstTheirChecksum) {
  for (const char* name : {"sum.igs.mha", "sum.igs.nrrd"}) {
    const fs::path path = Temporary(name);
    SequenceWriteExample(path, {.width = 8, .height = 8, .compressed = true}, 2);
    std::string text = ReadTextFile(path);
    const std::size_t checksum = text.size() - (path.extension() == ".mha" ? 1 : 5);
    text[checksum] = static_cast<char>(text[checksum] ^ 1);
    WriteTextFile(path, text);
    SequenceFile file(path);
    EXPECT_EQ(file.ReadImage(0), NoisyImage(64, 0));
    EXPECT_THAT([&] { file.ReadImage(1); }, ThrowsMessage<InputError>(HasSubstr("damaged")));
  }
}

TEST_F(SequenceFileTest, SurvivesDamagedFiles) {
  const auto read_all = [](const fs::path& path) {
    SequenceFile file(path);
    for (std::size_t i = 0; i < file.num_frames(); ++i) {
      file.TimeNs(i);
      file.Transforms(i).Find("Probe", "Reference");
      if (file.has_images()) file.ReadImage(i);
    }
  };
  for (const char* name : {"fuzz.igs.mha", "fuzz_z.igs.mha", "fuzz.igs.nrrd", "fuzz_z.igs.nrrd"}) {
    const fs::path path = Temporary(name);
    SequenceWriteExample(
        path,
        {.width = 16, .height = 8, .compressed = path.string().find("_z") != std::string::npos}, 6);
    const int refused =
        testing_support::ReadDamagedCopies(ReadTextFile(path), path, 400, [&] { read_all(path); });
    EXPECT_GT(refused, 100) << name;
  }
}

}  // namespace
}  // namespace acus::session
