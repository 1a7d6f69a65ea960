#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/volume_io.h"
#include "support/bound.h"
#include "support/dicom_writer.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::DicomSlice;
using testing_support::TemporaryFolder;
using testing_support::WriteDicomSlice;

/// A field that is linear in space, so that linear interpolation must keep it: HU at a point.
double FieldHu(const Eigen::Vector3d& p) {
  return 20.0 * p[0] - 10.0 * p[1] + 5.0 * p[2] + 100.0;
}

DicomSlice SliceAt(const Eigen::Vector3d& position_mm) {
  DicomSlice slice;
  slice.position_mm = position_mm;
  for (int j = 0; j < slice.rows; ++j) {
    for (int i = 0; i < slice.columns; ++i) {
      const Eigen::Vector3d p = position_mm + slice.column_axis * (i * slice.spacing_mm[0]) +
                                slice.row_axis * (j * slice.spacing_mm[1]);
      slice.stored.push_back(static_cast<std::int16_t>(std::lround(FieldHu(p))));
    }
  }
  return slice;
}

void WriteStack(const fs::path& folder, int count, double step_mm) {
  for (int k = 0; k < count; ++k) {
    // Names in another order than positions: the position must decide.
    WriteDicomSlice(folder / Message("slice", (k * 7) % 10),
                    SliceAt({5.0, -3.0, 40.0 + k * step_mm}));
  }
}

CtVolume Read(const fs::path& folder, const std::string& series = "") {
  return ReadCt(folder, series, RunContext{});
}

TEST(DicomSeries, SlicesAreOrderedByPositionAndPlacedInLps) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 10, 2.0);
  const CtVolume ct = Read(folder.path());
  EXPECT_TRUE((ct.geometry.size == Eigen::Array3i(16, 12, 10)).all());
  EXPECT_TRUE(ct.geometry.spacing_mm.isApprox(Eigen::Array3d(0.5, 0.75, 2.0)));
  const Eigen::Affine3d ct_from_index = ct.geometry.ct_from_index();
  for (const Eigen::Array3i& v :
       {Eigen::Array3i(0, 0, 0), Eigen::Array3i(15, 3, 9), Eigen::Array3i(4, 11, 5)}) {
    const Eigen::Vector3d p = ct_from_index * v.cast<double>().matrix();
    EXPECT_NEAR(ct.At(v[0], v[1], v[2]), FieldHu(p), 0.51);
  }
}

TEST(DicomSeries, ProgressRisesToOne) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 10, 2.0);
  RunContext context;
  std::vector<double> fractions;
  context.on_progress = [&](std::string_view, double fraction) { fractions.push_back(fraction); };
  ReadCt(folder.path(), "", context);
  EXPECT_TRUE(std::ranges::is_sorted(fractions));
  EXPECT_GE(fractions.front(), 0.0);
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(DicomSeries, OtherFilesInTheFolderAreIgnored) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "deeper");
  WriteStack(folder / "deeper", 4, 2.0);
  std::ofstream(folder / "readme.txt") << "not an image";
  std::ofstream(folder / "zero.dcm");
  std::ofstream(folder / "image.dcm") << std::string(500, 'x');
  EXPECT_EQ(Read(folder.path()).geometry.size[2], 4);
}

TEST(DicomSeries, ASpacingWithDecimalCommasIsNotReadAsItsWholePart) {
  const TemporaryFolder folder;
  WriteDicomSlice(folder / "slice", SliceAt({0, 0, 0}));
  EXPECT_TRUE(ReadDicomHeader(folder / "slice")->is_placed);
  std::string bytes = ReadTextFile(folder / "slice");
  const auto at = bytes.find("0.75\\0.5");
  ASSERT_NE(at, bytes.npos);
  bytes[at + 1] = bytes[at + 6] = ',';
  WriteTextFile(folder / "slice", bytes);
  EXPECT_FALSE(ReadDicomHeader(folder / "slice")->is_placed);
}

TEST(DicomSeries, SeveralSeriesMustBeChosen) {
  const TemporaryFolder folder;
  for (int k = 0; k < 5; ++k) {
    DicomSlice slice = SliceAt({0, 0, 3.0 * k});
    WriteDicomSlice(folder / Message("a", k), slice);
    slice.series_uid = "9.8.7";
    slice.description = "lung kernel";
    if (k < 4) WriteDicomSlice(folder / Message("b", k), slice);
  }
  const auto list = ListDicomSeries(folder.path());
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].uid, "1.2.3");
  EXPECT_EQ(list[1].files.size(), 4U);
  EXPECT_THAT([&] { Read(folder.path()); },
              ThrowsMessage<InputError>(testing::AllOf(HasSubstr("9.8.7"), HasSubstr("--series"))));
  EXPECT_EQ(Read(folder.path(), "9.8.7").geometry.size[2], 4);
  EXPECT_EQ(Read(folder.path(), "lung").geometry.size[2], 4);
  EXPECT_EQ(Read(folder.path(), "1.2").geometry.size[2], 5);
  EXPECT_THAT([&] { Read(folder.path(), "bone"); },
              ThrowsMessage<InputError>(HasSubstr("no series is called 'bone'")));
}

TEST(DicomSeries, AScoutOfAnotherSizeIsNotMixedIn) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 5, 2.0);
  DicomSlice scout = SliceAt({0, 0, 0});
  scout.columns = 8;
  scout.rows = 24;
  WriteDicomSlice(folder / "scout", scout);
  EXPECT_EQ(Read(folder.path()).geometry.size[2], 5);
}

TEST(DicomSeries, AMissingSliceIsNamedAndRefused) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 10, 2.0);
  fs::remove(folder / "slice5");  // The sixth position.
  EXPECT_THAT([&] { Read(folder.path()); },
              ThrowsMessage<InputError>(testing::AllOf(HasSubstr("not evenly spaced: 4 mm"),
                                                       HasSubstr("2 mm elsewhere"))));
}

TEST(DicomSeries, ACopyIsLeftOutAndAnotherSliceAtThePlaceIsRefused) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 5, 2.0);
  fs::copy_file(folder / "slice7", folder / "copy");
  EXPECT_EQ(Read(folder.path()).geometry.size[2], 5);
  DicomSlice other = SliceAt({5.0, -3.0, 44.0});
  for (auto& value : other.stored) value = static_cast<std::int16_t>(value + 7);
  WriteDicomSlice(folder / "other", other);
  EXPECT_THAT([&] { Read(folder.path()); }, ThrowsMessage<InputError>(HasSubstr("same place")));
}

TEST(DicomSeries, OrientationsThatDifferByAMilliradianAreOneStack) {
  const TemporaryFolder folder;
  for (int k = 0; k < 6; ++k) {
    DicomSlice slice = SliceAt({0, 0, 2.0 * k});
    if (k % 2 == 1) {
      slice.column_axis = Eigen::Vector3d(1.0, 0.001, 0.0).normalized();
      slice.row_axis = Eigen::Vector3d(-0.001, 1.0, 0.0).normalized();
    }
    WriteDicomSlice(folder / Message("slice", k), slice);
  }
  EXPECT_EQ(Read(folder.path()).geometry.size[2], 6);
}

TEST(DicomSeries, PositionsRoundedToATenthGiveTheirMeanDistance) {
  const TemporaryFolder folder;
  for (int k = 0; k < 40; ++k) {
    WriteDicomSlice(folder / Message("slice", k), SliceAt({0, 0, std::round(6.25 * k) / 10.0}));
  }
  EXPECT_NEAR(Read(folder.path()).geometry.spacing_mm[2], 0.625, 0.002);
  fs::remove(folder / "slice17");
  EXPECT_THAT([&] { Read(folder.path()); },
              ThrowsMessage<InputError>(HasSubstr("not evenly spaced")));
}

TEST(DicomSeries, TwoVolumesOfOneSeriesAreTwo) {
  const TemporaryFolder folder;
  for (int k = 0; k < 10; ++k) {
    DicomSlice slice = SliceAt({0, 0, 2.0 * (k % 5)});
    for (auto& value : slice.stored) value = static_cast<std::int16_t>(value + k);
    WriteDicomSlice(folder / Message("slice", k), slice);
  }
  const auto list = ListDicomSeries(folder.path());
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].files.size(), 5U);
  EXPECT_THAT(list[1].description, HasSubstr("[part 2]"));
}

TEST(DicomSeries, BlocksOfDifferentStepsAreChosenByName) {
  const TemporaryFolder folder;
  const double places_mm[] = {0, 3, 6, 9, 12, 18, 24, 30, 36};
  for (int k = 0; k < 9; ++k) WriteDicomSlice(folder / Message(k), SliceAt({0, 0, places_mm[k]}));
  EXPECT_THAT([&] { ReadCt(folder.path(), "", RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("[block 2 of 2]")));
  const CtVolume ct = ReadCt(folder.path(), "block 2", RunContext{});
  EXPECT_EQ(ct.geometry.size[2], 4);
  EXPECT_NEAR(ct.geometry.spacing_mm[2], 6.0, 1e-9);
  EXPECT_NEAR(ct.geometry.origin_mm[2], 18.0, 1e-9);
  EXPECT_EQ(ReadCt(folder.path(), "block 1", RunContext{}).geometry.size[2], 5);
}

TEST(DicomSeries, ATiltedGantryIsStraightened) {
  const testing_support::HardCase hard("A gantry tilted by 20 degrees: slices are sheared.");
  testing_support::Largest off_hu;
  const TemporaryFolder folder;
  const double tilt_rad = 20.0 * M_PI / 180.0;
  for (int k = 0; k < 8; ++k) {
    DicomSlice slice;
    slice.rows = 40;
    slice.row_axis = {0.0, std::cos(tilt_rad), -std::sin(tilt_rad)};
    slice.position_mm = {-2.0, 7.0, 1.5 * k};  // The table moves along z, not along the normal.
    for (int j = 0; j < slice.rows; ++j) {
      for (int i = 0; i < slice.columns; ++i) {
        const Eigen::Vector3d p =
            slice.position_mm + slice.column_axis * (i * 0.5) + slice.row_axis * (j * 0.75);
        slice.stored.push_back(static_cast<std::int16_t>(std::lround(FieldHu(p))));
      }
    }
    WriteDicomSlice(folder / Message(k), slice);
  }
  std::string warning;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warning = text; };
  const CtVolume ct = ReadCt(folder.path(), "", context);
  EXPECT_THAT(warning, HasSubstr("tilted by 20"));
  EXPECT_NEAR(ct.geometry.spacing_mm[2], 1.5 * std::cos(tilt_rad), 1e-6);
  int inside = 0;
  for (int k = 0; k < ct.geometry.size[2]; ++k) {
    for (int j = 8; j < 35; ++j) {  // Rows that every slice covers.
      const Eigen::Vector3d p = ct.geometry.ct_from_index() * Eigen::Vector3d(5, j, k);
      off_hu.Add(std::abs(ct.At(5, j, k) - FieldHu(p)));
      ++inside;
    }
  }
  hard.Expect("difference from the field", off_hu, testing_support::AtMost(1.1), "HU");
  EXPECT_EQ(inside, 8 * 27);
}

TEST(DicomSeries, UnsignedPixelsAreRescaledAndPaddingBecomesAir) {
  const TemporaryFolder folder;
  for (int k = 0; k < 3; ++k) {
    DicomSlice slice = SliceAt({0, 0, 2.0 * k});
    slice.is_signed = false;
    slice.slope = 2.0;
    slice.intercept = -1024.0;
    slice.stored.assign(slice.stored.size(), 600);
    slice.stored[0] = 0;
    slice.stored[1] = static_cast<std::int16_t>(40000);  // Above the signed range.
    WriteDicomSlice(folder / Message(k), slice);
  }
  const CtVolume ct = Read(folder.path());
  EXPECT_EQ(ct.voxels[0], -1024);
  EXPECT_EQ(ct.voxels[1], 32767);
  EXPECT_EQ(ct.voxels[2], 176);
}

TEST(DicomSeries, RefusesWhatIsNoCt) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { Read(folder.path()); }, ThrowsMessage<InputError>(HasSubstr("no DICOM image")));
  for (int k = 0; k < 4; ++k) {
    DicomSlice slice = SliceAt({0, 0, 2.0 * k});
    slice.modality = "MR";
    WriteDicomSlice(folder / Message(k), slice);
  }
  EXPECT_THAT([&] { Read(folder.path()); },
              ThrowsMessage<InputError>(HasSubstr("looks like a CT")));
  EXPECT_THAT([&] { Read(folder.path(), "1.2.3"); },
              ThrowsMessage<InputError>(HasSubstr("modality is MR")));
  EXPECT_THAT([&] { Read(folder / "0"); }, ThrowsMessage<InputError>(HasSubstr("of the kind MR")));
  WriteDicomSlice(folder / "ct", SliceAt({0, 0, 0}));
  EXPECT_THAT([&] { Read(folder / "ct"); },
              ThrowsMessage<InputError>(HasSubstr("one DICOM slice")));
}

TEST(DicomSeries, ATruncatedSliceIsAnInputErrorThatNamesIt) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 5, 2.0);
  fs::resize_file(folder / "slice7", fs::file_size(folder / "slice7") - 10);
  EXPECT_THAT([&] { Read(folder.path()); },
              ThrowsMessage<InputError>(testing::AllOf(HasSubstr("slice7"), HasSubstr("cut off"))));
}

TEST(DicomSeries, AnEmptyElementMayBeTheLast) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 5, 2.0);
  const CtVolume before = Read(folder.path());
  std::ofstream(folder / "slice7", std::ios::binary | std::ios::app)
      << std::string("\xE1\x7F\x10\0LO\0\0", 8);
  EXPECT_EQ(Read(folder.path()).voxels, before.voxels);
}

TEST(DicomSeries, SequencesNestedTooDeeplyAreRefused) {
  const TemporaryFolder folder;
  std::string bytes = std::string(128, '\0') + "DICM";
  const std::string sequence("\x08\0\x40\x11SQ\0\0\xFF\xFF\xFF\xFF", 12);
  const std::string item("\xFE\xFF\0\xE0\xFF\xFF\xFF\xFF", 8);
  for (int depth = 0; depth < 100'000; ++depth) bytes += sequence + item;
  std::ofstream(folder / "slice1", std::ios::binary) << bytes;
  EXPECT_THAT([&] { ReadDicomHeader(folder / "slice1"); },
              ThrowsMessage<InputError>(
                  testing::AllOf(HasSubstr("slice1"), HasSubstr("nested too deeply"))));
}

TEST(DicomSeries, FlippedBitsAreReadOrRefused) {
  const TemporaryFolder folder;
  WriteStack(folder.path(), 4, 2.0);
  std::ifstream file(folder / "slice4", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  RandomStream random(11, "dicom", 0);
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string broken = bytes;
    const auto at =
        128 + static_cast<std::size_t>(random.Uniform() * static_cast<double>(bytes.size() - 128));
    broken[at] = static_cast<char>(broken[at] ^ (1 << static_cast<int>(random.Uniform() * 8)));
    std::ofstream(folder / "slice4", std::ios::binary) << broken;
    try {
      const CtVolume ct = Read(folder.path());
      EXPECT_EQ(ct.voxels.size(), ct.geometry.num_voxels());
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 40);
}

}  // namespace
}  // namespace acus::volume
