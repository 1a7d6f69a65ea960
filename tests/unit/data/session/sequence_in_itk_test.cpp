// Our sequence files open in ITK, on which 3D Slicer's readers are built.
#include <gtest/gtest.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include "acus/data/session/sequence_writer.h"
#include "support/temporary_folder.h"

namespace acus::session {
namespace {

constexpr std::size_t kWidth = 23;
constexpr std::size_t kHeight = 11;
constexpr std::size_t kFrames = 4;

std::vector<std::uint8_t> WriteExample(const std::filesystem::path& path, bool compressed) {
  SequenceWriter writer(path, {.width = kWidth, .height = kHeight, .compressed = compressed});
  std::vector<std::uint8_t> all;
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    std::vector<std::uint8_t> image(kWidth * kHeight);
    for (std::size_t i = 0; i < image.size(); ++i) {
      image[i] = static_cast<std::uint8_t>(i * 7 + frame * 13);
    }
    SequenceFields fields;
    AddTransform(fields, "ProbeToReference", Eigen::Matrix4d::Identity(), true);
    writer.AddFrame(static_cast<std::int64_t>(frame) * 40'000'000, image, fields);
    all.insert(all.end(), image.begin(), image.end());
  }
  writer.Commit();
  return all;
}

std::vector<std::uint8_t> ReadWith(itk::ImageIOBase& io, const std::filesystem::path& path) {
  EXPECT_TRUE(io.CanReadFile(path.c_str()));
  io.SetFileName(path.string());
  io.ReadImageInformation();
  EXPECT_EQ(io.GetDimensions(0), kWidth);
  EXPECT_EQ(io.GetDimensions(1), kHeight);
  const unsigned int num_axes = io.GetNumberOfDimensions();
  itk::ImageIORegion region(num_axes);
  for (unsigned int axis = 0; axis < num_axes; ++axis) region.SetSize(axis, io.GetDimensions(axis));
  io.SetIORegion(region);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(io.GetImageSizeInBytes()));
  io.Read(pixels.data());
  return pixels;
}

TEST(SequenceInItk, MetaImageHasTheSamePixelsAndFields) {
  const testing_support::TemporaryFolder folder;
  for (const bool compressed : {false, true}) {
    const auto path = folder / (compressed ? "z.igs.mha" : "raw.igs.mha");
    const auto written = WriteExample(path, compressed);
    const auto io = itk::MetaImageIO::New();
    EXPECT_EQ(ReadWith(*io, path), written);
    EXPECT_EQ(io->GetNumberOfDimensions(), 3U);
    EXPECT_EQ(io->GetDimensions(2), kFrames);
    std::string value;
    EXPECT_TRUE(itk::ExposeMetaData<std::string>(
        io->GetMetaDataDictionary(), "Seq_Frame0003_ProbeToReferenceTransformStatus", value));
    EXPECT_EQ(value, "OK");
  }
}

TEST(SequenceInItk, NrrdHasTheSamePixels) {
  const testing_support::TemporaryFolder folder;
  for (const bool compressed : {false, true}) {
    const auto path = folder / (compressed ? "z.igs.nrrd" : "raw.igs.nrrd");
    const auto written = WriteExample(path, compressed);
    const auto io = itk::NrrdImageIO::New();
    const auto read = ReadWith(*io, path);
    // ITK takes the axis of kind "list" for the components of its pixels, and moves it first.
    ASSERT_EQ(io->GetNumberOfComponents(), kFrames);
    ASSERT_EQ(read.size(), written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i], written[i % kFrames * kWidth * kHeight + i / kFrames]);
    }
  }
}

}  // namespace
}  // namespace acus::session
