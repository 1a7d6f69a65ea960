#include "acus/data/volume/volume_io.h"

#include <cstring>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/scalar_file.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::TemporaryFolder;

/// Right-handed and oblique: no axis along a patient axis.
Geometry ObliqueGeometry() {
  Geometry g;
  g.size = {7, 5, 4};
  g.spacing_mm = {0.5, 0.8, 2.5};
  g.origin_mm = {-120.25, 33.5, 412.125};
  g.direction = (Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()) *
                 Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitZ()))
                    .toRotationMatrix();
  return g;
}

/// Every voxel has its own value, among them the ends of the range.
CtVolume NumberedCt(const Geometry& geometry) {
  CtVolume ct(geometry);
  for (std::size_t i = 0; i < ct.voxels.size(); ++i)
    ct.voxels[i] = static_cast<std::int16_t>(7 * i);
  ct.voxels.front() = -1024;
  ct.voxels.back() = 32767;
  return ct;
}

std::string Slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class EveryFormat : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryFormat, KeepsValuesAndObliqueGeometry) {
  const TemporaryFolder folder;
  const fs::path path = folder / (std::string("ct") + GetParam());
  const CtVolume written = NumberedCt(ObliqueGeometry());
  WriteCt(path, written);
  const CtVolume read = ReadCt(path, "", RunContext{});
  EXPECT_EQ(read.voxels, written.voxels);
  EXPECT_TRUE(read.geometry.Matches(written.geometry, 1e-3)) << read.geometry.origin_mm.transpose();
}

TEST_P(EveryFormat, ALeftHandedVolumeBecomesRightHandedWithEveryVoxelInItsPlace) {
  const TemporaryFolder folder;
  const fs::path path = folder / (std::string("ct") + GetParam());
  Geometry left = ObliqueGeometry();
  left.direction.col(1) *= -1.0;
  const CtVolume written = NumberedCt(left);
  WriteCt(path, written);
  const CtVolume read = ReadCt(path, "", RunContext{});
  ASSERT_GT(read.geometry.direction.determinant(), 0.0);
  const Eigen::Affine3d from_ct = read.geometry.index_from_ct();
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 7; ++i) {
        const Eigen::Vector3d at = from_ct * (left.ct_from_index() * Eigen::Vector3d(i, j, k));
        const Eigen::Array3i index = at.array().round().cast<int>();
        ASSERT_LT((at.array() - index.cast<double>()).abs().maxCoeff(), 1e-3);
        EXPECT_EQ(read.At(index[0], index[1], index[2]), written.At(i, j, k));
      }
    }
  }
}

TEST_P(EveryFormat, CutOffAnywhereIsAnInputError) {
  const TemporaryFolder folder;
  const fs::path whole = folder / (std::string("ct") + GetParam());
  WriteCt(whole, NumberedCt(ObliqueGeometry()));
  const std::string bytes = Slurp(whole);
  const fs::path cut = folder / (std::string("cut") + GetParam());
  // The last bytes of a compressed file hold only its checksum, which not every reader looks at.
  for (std::size_t size = 0; size + 16 < bytes.size(); size += 5) {
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, size);
    EXPECT_THROW(ReadCt(cut, "", RunContext{}), InputError) << size << " of " << bytes.size();
  }
}

TEST_P(EveryFormat, FlippedBitsAreReadOrRefused) {
  const TemporaryFolder folder;
  const fs::path whole = folder / (std::string("ct") + GetParam());
  WriteCt(whole, NumberedCt(ObliqueGeometry()));
  const std::string bytes = Slurp(whole);
  const fs::path flipped = folder / (std::string("flipped") + GetParam());
  RandomStream random(3, "bits", 0);
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string broken = bytes;
    // Half of the flips go into the header, where they do most harm.
    const std::size_t range =
        trial % 2 == 0 ? std::min<std::size_t>(400, bytes.size()) : bytes.size();
    const auto at = static_cast<std::size_t>(random.Uniform() * static_cast<double>(range));
    broken[at] = static_cast<char>(broken[at] ^ (1 << static_cast<int>(random.Uniform() * 8)));
    std::ofstream(flipped, std::ios::binary) << broken;
    try {
      const CtVolume ct = ReadCt(flipped, "", RunContext{});
      EXPECT_EQ(ct.voxels.size(), ct.geometry.num_voxels());
      EXPECT_TRUE(ct.geometry.origin_mm.allFinite());
      EXPECT_TRUE((ct.geometry.spacing_mm > 0.0).all());
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("flipped"));
      ++refused;
    }
  }
  EXPECT_GT(refused, 20);
}

TEST_P(EveryFormat, LabelsKeepTheirValues) {
  const TemporaryFolder folder;
  const fs::path path = folder / (std::string("labels") + GetParam());
  CtVolume numbers(ObliqueGeometry());
  for (std::size_t i = 0; i < numbers.voxels.size(); ++i)
    numbers.voxels[i] = static_cast<std::int16_t>(i * 3);
  WriteCt(path, numbers);
  const Grid<std::int32_t> read = ReadIntegerVolume(path);
  for (std::size_t i = 0; i < read.voxels.size(); ++i)
    EXPECT_EQ(read.voxels[i], static_cast<int>(i * 3));
  EXPECT_THAT([&] { ReadLabelMap(path); },
              ThrowsMessage<InputError>(HasSubstr("outside 0 to 255")));
}

INSTANTIATE_TEST_SUITE_P(Formats, EveryFormat,
                         ::testing::Values(".nrrd", ".mha", ".nii", ".nii.gz"),
                         [](const auto& param) {
                           std::string name = param.param + 1;
                           std::erase(name, '.');
                           return name;
                         });

TEST(ReadCt, EverySpaceOfAnNrrdBecomesLps) {
  const TemporaryFolder folder;
  const CtVolume written = NumberedCt(ObliqueGeometry());
  WriteCt(folder / "ct.nrrd", written);
  const std::string bytes = Slurp(folder / "ct.nrrd");
  const std::string lps = "space: left-posterior-superior";
  const std::size_t at = bytes.find(lps);
  ASSERT_NE(at, bytes.npos);
  const std::pair<const char*, Eigen::Vector3d> spaces[] = {
      {"LPS", {1, 1, 1}},
      {"RAS", {-1, -1, 1}},
      {"right-anterior-superior", {-1, -1, 1}},
      {"left-anterior-superior", {1, -1, 1}},
      {"LAS", {1, -1, 1}}};
  for (const auto& [space, signs] : spaces) {
    std::string changed = bytes;
    changed.replace(at, lps.size(), Message("space: ", space));
    WriteTextFile(folder / "changed.nrrd", changed);
    const CtVolume read = ReadCt(folder / "changed.nrrd", "", RunContext{});
    const auto& size = read.geometry.size;
    const auto first = std::ranges::find(read.voxels, -1024) - read.voxels.begin();
    const Eigen::Vector3d index(static_cast<double>(first % size[0]),
                                static_cast<double>(first / size[0] % size[1]),
                                static_cast<double>(first / (size[0] * size[1])));
    const Eigen::Vector3d place_mm = read.geometry.ct_from_index() * index;
    const Eigen::Vector3d expected_mm = signs.asDiagonal() * written.geometry.origin_mm;
    EXPECT_LT((place_mm - expected_mm).norm(), 1e-6) << space;
  }
  std::string warning;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warning = text; };
  std::string none = bytes;
  none.replace(at, lps.size(), "space dimension: 3");
  WriteTextFile(folder / "none.nrrd", none);
  ReadCt(folder / "none.nrrd", "", context);
  EXPECT_THAT(warning, HasSubstr("not say how the patient lies"));
}

TEST(ReadCt, TakesTheChosenOneOfSeveralVolumes) {
  const TemporaryFolder folder;
  const CtVolume first = NumberedCt(ObliqueGeometry());
  CtVolume third = first;
  for (auto& hu : third.voxels) hu = static_cast<std::int16_t>(hu / 2);
  WriteCt(folder / "first.nii", first);
  WriteCt(folder / "third.nii", third);
  std::string bytes = Slurp(folder / "first.nii");
  bytes += bytes.substr(352) + Slurp(folder / "third.nii").substr(352);
  bytes[40] = 4;  // dim[0], and dim[4].
  bytes[48] = 3;
  WriteTextFile(folder / "four.nii", bytes);
  ASSERT_EQ(NumVolumes(folder / "four.nii"), 3);
  const CtVolume read = ReadCt(folder / "four.nii", "3", RunContext{});
  EXPECT_EQ(read.voxels, third.voxels);
  EXPECT_TRUE(read.geometry.Matches(first.geometry, 1e-3));
  EXPECT_EQ(ReadCt(folder / "four.nii", "2", RunContext{}).voxels, first.voxels);
  for (const char* none : {"", "0", "4", "1.5", "x"}) {
    EXPECT_THAT([&] { ReadCt(folder / "four.nii", none, RunContext{}); },
                ThrowsMessage<InputError>(HasSubstr("Choose one with --series 1 to 3")));
  }
  WriteTextFile(folder / "four.nii", bytes.substr(0, bytes.size() - 10));
  EXPECT_THROW(ReadCt(folder / "four.nii", "1", RunContext{}), InputError);
}

TEST(VolumeStem, IsTheNameWithoutTheEndingsOfVolumes) {
  EXPECT_EQ(VolumeStem("a/spleen.nii.gz"), "spleen");
  EXPECT_EQ(VolumeStem("spleen.seg.nrrd"), "spleen");
  EXPECT_EQ(VolumeStem("s.1.mha"), "s.1");
}

TEST(LabelMap, NamesAndVoxelsComeBackFromASegNrrd) {
  const TemporaryFolder folder;
  LabelMap labels(ObliqueGeometry());
  labels.At(1, 2, 3) = LabelOf("bone");
  labels.At(2, 2, 3) = LabelOf("bone");
  labels.At(0, 4, 0) = 77;
  labels.names = {{LabelOf("bone"), "bone"}, {77, "my implant"}, {78, "does not occur"}};
  const fs::path path = folder / "labels.seg.nrrd";
  WriteLabelMap(path, labels);
  const LabelMap read = ReadLabelMap(path);
  EXPECT_EQ(read.voxels, labels.voxels);
  EXPECT_TRUE(read.geometry.Matches(labels.geometry, 1e-6));
  const std::map<Label, std::string> expected = {{LabelOf("bone"), "bone"}, {77, "my implant"}};
  EXPECT_EQ(read.names, expected);
  // What 3D Slicer looks for.
  const std::string text = Slurp(path);
  EXPECT_THAT(text, HasSubstr("Segment0_Name:=bone"));
  EXPECT_THAT(text, HasSubstr("Segment0_Extent:=1 2 2 2 3 3"));
  EXPECT_THAT(text, HasSubstr("Segment1_LabelValue:=77"));
  EXPECT_THAT(text, HasSubstr("Segment1_Layer:=0"));
  EXPECT_THAT(text, HasSubstr("space: left-posterior-superior"));
}

TEST(ReadTissues, GoesByTheNamesOfTheSegmentsNotByTheirNumbers) {
  const TemporaryFolder folder;
  LabelMap labels(ObliqueGeometry());
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) labels.voxels[i] = i % 4 == 3 ? 77 : i % 4;
  labels.names = {{1, "bone"}, {2, "skin"}, {77, "clip"}};
  WriteLabelMap(folder / "slicer.seg.nrrd", labels);
  const LabelMap read = ReadTissues(folder / "slicer.seg.nrrd");
  const Label bone = LabelOf("bone");
  const Label skin = LabelOf("skin");
  const Label expected[] = {0, bone, skin, 77};
  for (std::size_t i = 0; i < read.voxels.size(); ++i) ASSERT_EQ(read.voxels[i], expected[i % 4]);
  EXPECT_EQ(read.names,
            (std::map<Label, std::string>{{skin, "skin"}, {bone, "bone"}, {77, "clip"}}));
}

TEST(ReadTissues, RefusesAStandardNumberUnderAnotherName) {
  const TemporaryFolder folder;
  LabelMap labels(ObliqueGeometry());
  labels.voxels[0] = 3;
  labels.names = {{3, "Segment_3"}};
  WriteLabelMap(folder / "slicer.seg.nrrd", labels);
  EXPECT_THAT([&] { ReadTissues(folder / "slicer.seg.nrrd"); },
              ThrowsMessage<InputError>(testing::AllOf(HasSubstr("label 3 is called 'Segment_3'"),
                                                       HasSubstr("--import"))));
}

TEST(ReadCt, CompressionMayBeDeclaredInAnySpellingThatMetaImageHas) {
  const TemporaryFolder folder;
  const CtVolume written = NumberedCt(ObliqueGeometry());
  WriteCt(folder / "ct.mha", written);
  std::string bytes = Slurp(folder / "ct.mha");
  const auto at = bytes.find("CompressedData = True");
  ASSERT_NE(at, bytes.npos);
  bytes.replace(at, 21, "CompressedData = true");
  std::ofstream(folder / "ct.mha", std::ios::binary) << bytes;
  EXPECT_EQ(ReadCt(folder / "ct.mha", "", RunContext{}).voxels, written.voxels);
}

TEST(ReadCt, PaddingBelowAirBecomesAir) {
  const TemporaryFolder folder;
  CtVolume ct = NumberedCt(ObliqueGeometry());
  ct.voxels[1] = -2000;
  ct.voxels[2] = -3024;
  ct.voxels[3] = -1023;
  WriteCt(folder / "ct.nrrd", ct);
  const CtVolume read = ReadCt(folder / "ct.nrrd", "", RunContext{});
  EXPECT_EQ(read.voxels[1], -1024);
  EXPECT_EQ(read.voxels[2], -1024);
  EXPECT_EQ(read.voxels[3], -1023);
}

TEST(ReadCt, WarnsWhenThereIsNoAir) {
  const TemporaryFolder folder;
  CtVolume ct = NumberedCt(ObliqueGeometry());
  ct.voxels[0] = 0;
  WriteCt(folder / "ct.nrrd", ct);
  std::string warning;
  RunContext context;
  context.on_warning = [&](std::string_view text) { warning = text; };
  ReadCt(folder / "ct.nrrd", "", context);
  EXPECT_THAT(warning, HasSubstr("Hounsfield"));
}

TEST(ReadCt, RefusesValuesThatLostTheirIntercept) {
  const TemporaryFolder folder;
  CtVolume ct(ObliqueGeometry(), 1060);
  for (std::size_t i = 0; i < ct.voxels.size(); i += 2) ct.voxels[i] = 0;
  WriteCt(folder / "ct.nrrd", ct);
  EXPECT_THAT([&] { ReadCt(folder / "ct.nrrd", "", RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("subtract 1024")));
}

TEST(ReadCt, NiftiValuesHaveSlopeAndIntercept) {
  const TemporaryFolder folder;
  CtVolume stored(ObliqueGeometry());
  for (std::size_t i = 0; i < stored.voxels.size(); ++i) {
    stored.voxels[i] = static_cast<std::int16_t>(20 * i);
  }
  WriteCt(folder / "ct.nii", stored);
  std::string bytes = Slurp(folder / "ct.nii");
  const float slope_and_intercept[] = {0.5F, -1000.0F};
  std::memcpy(&bytes[112], slope_and_intercept, sizeof(slope_and_intercept));
  WriteTextFile(folder / "scaled.nii", bytes);
  const CtVolume read = ReadCt(folder / "scaled.nii", "", RunContext{});
  for (std::size_t i = 0; i < read.voxels.size(); ++i) {
    ASSERT_EQ(read.voxels[i], static_cast<int>(10 * i) - 1000);
  }
}

void Put(std::string& bytes, std::size_t at, auto value) {
  std::memcpy(&bytes[at], &value, sizeof value);
}

/// A NIfTI file with a sform alone, changed by `change`; returns what is read, and the warnings.
template <typename Change>
CtVolume ReadChanged(const TemporaryFolder& folder, const char* name, std::string& warnings,
                     const Change& change) {
  WriteCt(folder / "ct.nii", NumberedCt(ObliqueGeometry()));
  std::string bytes = Slurp(folder / "ct.nii");
  Put(bytes, 252, std::int16_t{0});
  Put(bytes, 254, std::int16_t{1});
  change(bytes);
  WriteTextFile(folder / name, bytes);
  RunContext context;
  context.on_warning = [&](std::string_view text) { warnings += text; };
  return ReadCt(folder / name, "", context);
}

TEST(ReadCt, NiftiThatIsShearedALittleGetsTheNearestRotation) {
  const TemporaryFolder folder;
  const auto sheared = [](double by_mm) {
    return [by_mm](std::string& bytes) {
      float value = 0.0F;
      std::memcpy(&value, &bytes[284], sizeof value);
      Put(bytes, 284, static_cast<float>(value + by_mm));
    };
  };
  std::string warnings;
  const CtVolume read = ReadChanged(folder, "sheared.nii", warnings, sheared(0.005));
  EXPECT_LT(
      (read.geometry.direction.transpose() * read.geometry.direction - Eigen::Matrix3d::Identity())
          .norm(),
      1e-5);
  EXPECT_TRUE(read.geometry.Matches(ObliqueGeometry(), 0.05));
  EXPECT_THAT(warnings, HasSubstr("the nearest rotation is used"));
  EXPECT_THAT([&] { ReadChanged(folder, "more.nii", warnings, sheared(0.1)); },
              ThrowsMessage<InputError>(HasSubstr("degrees from perpendicular")));
}

TEST(ReadCt, NiftiSaysWhichOfTwoFormsIsUsed) {
  const TemporaryFolder folder;
  std::string warnings;
  const CtVolume read = ReadChanged(folder, "two.nii", warnings, [](std::string& bytes) {
    Put(bytes, 252, std::int16_t{1});
    float value = 0.0F;
    std::memcpy(&value, &bytes[292], sizeof value);
    Put(bytes, 292, value - 5.0F);  // In RAS.
  });
  EXPECT_THAT(warnings, HasSubstr("by up to 5 mm; the sform is used"));
  EXPECT_NEAR(read.geometry.origin_mm.x(), ObliqueGeometry().origin_mm.x() + 5.0, 1e-3);
}

TEST(ReadCt, Nifti2IsRead) {
  const TemporaryFolder folder;
  std::string warnings;
  ReadChanged(folder, "one.nii", warnings, [](std::string&) {});
  const std::string one = Slurp(folder / "one.nii");
  std::string two(544, '\0');
  Put(two, 0, std::int32_t{540});
  std::memcpy(&two[4], "n+2\0\r\n\032\n", 8);
  two.replace(12, 4, one, 70, 4);
  const auto get = [&one](std::size_t at, auto value) {
    std::memcpy(&value, &one[at], sizeof value);
    return value;
  };
  for (std::size_t i = 0; i < 8; ++i) {
    Put(two, 16 + 8 * i, static_cast<std::int64_t>(get(40 + 2 * i, std::int16_t{})));
    Put(two, 104 + 8 * i, static_cast<double>(get(76 + 4 * i, 0.0F)));
  }
  Put(two, 168, std::int64_t{544});
  Put(two, 176, 1.0);
  Put(two, 348, std::int32_t{1});
  for (std::size_t i = 0; i < 12; ++i) {
    Put(two, 400 + 8 * i, static_cast<double>(get(280 + 4 * i, 0.0F)));
  }
  WriteTextFile(folder / "two.nii", two + one.substr(352));
  const CtVolume read = ReadCt(folder / "two.nii", "", RunContext{});
  EXPECT_EQ(read.voxels, NumberedCt(ObliqueGeometry()).voxels);
  EXPECT_TRUE(read.geometry.Matches(ObliqueGeometry(), 1e-3));
}

TEST(ReadCt, NrrdInMetresIsConverted) {
  const TemporaryFolder folder;
  WriteCt(folder / "ct.nrrd", NumberedCt(ObliqueGeometry()));
  std::string text = Slurp(folder / "ct.nrrd");
  const std::size_t kinds = text.find("kinds:");
  ASSERT_NE(kinds, text.npos);
  text.insert(kinds, "space units: \"cm\" \"cm\" \"cm\"\n");
  WriteTextFile(folder / "cm.nrrd", text);
  const CtVolume read = ReadCt(folder / "cm.nrrd", "", RunContext{});
  EXPECT_NEAR(read.geometry.spacing_mm[2], 25.0, 1e-6);
  EXPECT_NEAR(read.geometry.origin_mm[0], -1202.5, 1e-3);
}

TEST(ReadCt, RefusesWhatIsNoVolume) {
  const TemporaryFolder folder;
  const auto refuses = [&](const std::string& name, const std::string& content,
                           const std::string& message) {
    WriteTextFile(folder / name, content);
    EXPECT_THAT([&] { ReadCt(folder / name, "", RunContext{}); },
                ThrowsMessage<InputError>(HasSubstr(message)))
        << name;
  };
  refuses("empty.nrrd", "", "is empty");
  refuses("text.nrrd", "hello", "NRRD");
  refuses("text.mha", "hello", "ElementDataFile");
  refuses("text.nii", "hello", "no NIfTI");
  refuses("image.png", "hello", "none of the volume formats");
  refuses("image.zip", "PK", "unpack the archive");
  refuses("flat.nrrd", "NRRD0004\ntype: short\ndimension: 2\nsizes: 2 2\nencoding: raw\n\n12345678",
          "2 dimensions");
  refuses("skewed.nrrd",
          "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
          "space directions: (1,0,0) (0.5,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n"
          "12345678",
          "not perpendicular");
  refuses(
      "huge.nrrd",
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 60000 60000 60000\nencoding: raw\n\n12345678",
      "more than the file can hold");
  refuses("series.nrrd",
          "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 2 2\nencoding: raw\n\n1234567812345678",
          "volumes");
  refuses("huge.mha",
          "ObjectType = Image\nNDims = 3\nDimSize = 60000 60000 60000\nElementType = MET_SHORT\n"
          "ElementDataFile = LOCAL\n12345678",
          "declares 432000 GB");
  refuses("dims.mha", "NDims = 99\nDimSize = 1 1 1\nElementDataFile = LOCAL\n", "NDims is 99");
  EXPECT_THAT([&] { ReadCt(folder / "none.nrrd", "", RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("no such file")));
}

TEST(ReadIntegerVolume, RefusesAnImageOfFractions) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "f.nrrd", std::string("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 3\n"
                                               "encoding: text\n\n1 2 2.5\n"));
  EXPECT_THAT([&] { ReadIntegerVolume(folder / "f.nrrd"); },
              ThrowsMessage<InputError>(HasSubstr("2.5 is not an integer")));
}

constexpr const char* kVti = R"(<?xml version="1.0"?>
<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">
  <ImageData WholeExtent="0 1 0 1 0 2" Origin="10 20 30" Spacing="0.5 1 2">
    <Piece Extent="0 1 0 1 0 2">
      <PointData Scalars="labels">
        <DataArray type="Int16" Name="labels" format="ascii">0 1 2 3 4 5 65 193 8 9 10 513</DataArray>
      </PointData>
    </Piece>
  </ImageData>
</VTKFile>
)";

TEST(Vti, IsReadWithItsGrid) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "l.vti", kVti);
  const auto grid = ReadIntegerVolume(folder / "l.vti");
  EXPECT_TRUE((grid.geometry.size == Eigen::Array3i(2, 2, 3)).all());
  EXPECT_TRUE((grid.geometry.spacing_mm == Eigen::Array3d(0.5, 1, 2)).all());
  EXPECT_EQ(grid.geometry.origin_mm, Eigen::Vector3d(10, 20, 30));
  EXPECT_EQ(grid.At(1, 1, 2), 513);
  EXPECT_EQ(grid.At(0, 1, 1), 65);
}

// The origin is that of the index 0, which a piece that was cut out need not have.
TEST(Vti, AnExtentMayBeginAnywhere) {
  const TemporaryFolder folder;
  std::string text = kVti;
  for (auto at = text.find("0 1 0 1 0 2"); at != text.npos; at = text.find("0 1 0 1 0 2")) {
    text.replace(at, 11, "4 5 -3 -2 6 8");
  }
  WriteTextFile(folder / "l.vti", text);
  const auto grid = ReadIntegerVolume(folder / "l.vti");
  EXPECT_TRUE((grid.geometry.size == Eigen::Array3i(2, 2, 3)).all());
  EXPECT_EQ(grid.geometry.origin_mm, Eigen::Vector3d(12, 17, 42));
  EXPECT_EQ(grid.At(1, 1, 2), 513);
}

TEST(Vti, CutOffOrFlippedIsReadOrRefused) {
  const TemporaryFolder folder;
  const std::string text = kVti;
  for (std::size_t size = 0; size + 12 < text.size(); size += 3) {
    WriteTextFile(folder / "cut.vti", text.substr(0, size));
    EXPECT_THROW(ReadIntegerVolume(folder / "cut.vti"), InputError) << size;
  }
  RandomStream random(5, "vti", 0);
  for (int trial = 0; trial < 300; ++trial) {
    std::string broken = text;
    const auto at = static_cast<std::size_t>(random.Uniform() * static_cast<double>(text.size()));
    broken[at] = static_cast<char>(broken[at] ^ (1 << static_cast<int>(random.Uniform() * 8)));
    WriteTextFile(folder / "flipped.vti", broken);
    try {
      const auto grid = ReadIntegerVolume(folder / "flipped.vti");
      EXPECT_EQ(grid.voxels.size(), grid.geometry.num_voxels());
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("flipped.vti"));
    }
  }
}

}  // namespace
}  // namespace acus::volume
