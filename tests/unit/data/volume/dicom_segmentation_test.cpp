#include "acus/data/volume/dicom_segmentation.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/dicom_segmentation_writer.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// 3 x 3 pixels of 1 x 2 mm in planes at z = 10 (both segments), 14 (the first) and 22 (the
/// second).
testing_support::DicomSegObject TwoSegments() {
  testing_support::DicomSegObject object;
  object.segments = {{.label = "Liver", .code = "10200004", .side_code = ""},
                     {.label = "K", .code = "64033007", .side_code = "7771000"}};
  object.frames = {{1, {5, 6, 10}, {1, 0, 0, 0, 0, 0, 0, 0, 1}},
                   {1, {5, 6, 14}, {0, 1, 0, 0, 0, 0, 0, 0, 0}},
                   {2, {5, 6, 22}, {0, 0, 0, 0, 1, 0, 0, 0, 0}},
                   {2, {5, 6, 10}, {1, 0, 1, 0, 0, 0, 0, 0, 0}}};
  return object;
}

TEST(DicomSegmentation, PlacesFramesAndNamesSegments) {
  const testing_support::TemporaryFolder folder;
  WriteDicomSegmentation(folder / "s.dcm", TwoSegments());
  ASSERT_TRUE(IsDicomSegmentation(folder / "s.dcm"));
  const NamedValues map = ReadNamedValues(folder / "s.dcm");
  const Geometry& grid = map.values.geometry;
  EXPECT_TRUE((grid.size == Eigen::Array3i(3, 3, 4)).all());
  EXPECT_TRUE(grid.spacing_mm.isApprox(Eigen::Array3d(1, 2, 4)));
  EXPECT_TRUE(grid.origin_mm.isApprox(Eigen::Vector3d(5, 6, 10)));
  EXPECT_EQ(map.values.At(0, 0, 0), 2);  // Both have it: the higher number remains.
  EXPECT_EQ(map.values.At(2, 2, 0), 1);
  EXPECT_EQ(map.values.At(2, 0, 0), 2);
  EXPECT_EQ(map.values.At(1, 0, 1), 1);
  EXPECT_EQ(map.values.At(1, 1, 3), 2);
  EXPECT_EQ(std::ranges::count(map.values.voxels, 0), 36 - 5);
  EXPECT_EQ(map.names.at(1).text, "Liver");
  EXPECT_EQ(map.names.at(2).codes, std::vector<std::string>{"64033007"});
  EXPECT_EQ(map.names.at(2).side, "left");
}

TEST(DicomSegmentation, LiesOnATurnedGridAsItsFramesSay) {
  const testing_support::TemporaryFolder folder;
  testing_support::DicomSegObject object = TwoSegments();
  object.orientation = "0\\1\\0\\0\\0\\-1";  // Sagittal: planes follow each other along -x.
  object.frames = {{1, {30, 0, 0}, {1, 0, 0, 0, 0, 0, 0, 0, 0}},
                   {2, {28, 0, 0}, {0, 1, 0, 0, 0, 0, 0, 0, 0}}};
  WriteDicomSegmentation(folder / "s.dcm", object);
  const NamedValues map = ReadDicomSegmentation(folder / "s.dcm");
  const Eigen::Vector3d second = map.values.geometry.ct_from_index() * Eigen::Vector3d(1, 0, 1);
  EXPECT_EQ(map.values.At(1, 0, 1), 2);
  EXPECT_TRUE(second.isApprox(Eigen::Vector3d(28, 1, 0))) << second;
}

TEST(DicomSegmentation, PixelsMayHaveOneOrTwoBytes) {
  const testing_support::TemporaryFolder folder;
  testing_support::DicomSegObject object;
  object.type = "LABELMAP";
  object.bits = 16;
  object.frames = {{0, {0, 0, 0}, {0, 1, 255, 256, 258, 4000, 65535, 0, 0}}};
  WriteDicomSegmentation(folder / "s.dcm", object);
  EXPECT_THAT(ReadDicomSegmentation(folder / "s.dcm").values.voxels,
              testing::ElementsAreArray(object.frames[0].pixels));
  // Of shares from 0 to 255, a half and more belong to the segment.
  object.type = "FRACTIONAL";
  object.bits = 8;
  object.frames = {{3, {0, 0, 0}, {0, 1, 127, 128, 255, 0, 0, 0, 0}}};
  WriteDicomSegmentation(folder / "s.dcm", object);
  EXPECT_THAT(ReadDicomSegmentation(folder / "s.dcm").values.voxels,
              testing::ElementsAre(0, 0, 0, 3, 3, 0, 0, 0, 0));
}

TEST(DicomSegmentation, RefusesWhatIsCutOffOrOnNoGrid) {
  const testing_support::TemporaryFolder folder;
  const auto refuses = [&](const testing_support::DicomSegObject& object, const char* message) {
    WriteDicomSegmentation(folder / "s.dcm", object);
    EXPECT_THAT([&] { ReadDicomSegmentation(folder / "s.dcm"); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  testing_support::DicomSegObject object = TwoSegments();
  object.frames[1].position_mm[2] = 15.5;
  refuses(object, "frame 3 does not lie on the grid");
  object = TwoSegments();
  object.frames[1].position_mm[2] = 10.02;
  object.frames[2].position_mm[2] = 1410.0;  // 70000 steps.
  refuses(object, "the segmentation is broken");
  object = TwoSegments();
  object.frames[3].pixels.clear();
  object.frames[2].pixels.clear();
  refuses(object, "bytes of pixels for 5");
  object = TwoSegments();
  object.frames[2].segment = 0;
  refuses(object, "frame 3 does not say of which segment");
  object = TwoSegments();
  object.frames.clear();
  refuses(object, "0 frames");
  WriteTextFile(folder / "t.dcm", "no DICOM at all");
  EXPECT_FALSE(IsDicomSegmentation(folder / "t.dcm"));
}

TEST(DicomSegmentation, AnyCutIsAnErrorAndNothingWorse) {
  const testing_support::TemporaryFolder folder;
  WriteDicomSegmentation(folder / "s.dcm", TwoSegments());
  std::ifstream in(folder / "s.dcm", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (std::size_t size = 140; size + 1 < whole.size(); size += 3) {
    std::ofstream(folder / "c.dcm", std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(ReadDicomSegmentation(folder / "c.dcm"), InputError) << size;
  }
}

}  // namespace
}  // namespace acus::volume
