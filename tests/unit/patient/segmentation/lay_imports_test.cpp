#include "acus/patient/segmentation/import/lay_imports.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/vertebra_names.h"
#include "support/nifti_writer.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::NiftiLabelXml;
using testing_support::WriteNiftiLabels;

/// Six voxels of 1 mm in a row, all muscle of 60 HU; the map files lie on the same grid.
struct RowOfVoxels {
  RowOfVoxels() {
    WriteNiftiLabels(folder / "grid.nii", 6, 1, 1, {1, 1, 1, 1, 1, 1}, {});
    const volume::Geometry grid = volume::ReadIntegerVolume(folder / "grid.nii").geometry;
    ct = volume::CtVolume(grid, 60);
    labels = volume::LabelMap(grid, volume::LabelOf("muscle"));
    context.on_warning = [this](std::string_view text) { warnings += text; };
  }
  std::string Lay(const std::vector<ForeignLabels>& maps) {
    LaidImports laid = LayImports({.maps = maps, .accept_implausible = false}, ct, labels, context);
    vertebrae = std::move(laid.vertebrae);
    return laid.report;
  }
  std::vector<std::string> Tissues() const {
    std::vector<std::string> names;
    for (const volume::Label label : labels.voxels) {
      names.emplace_back(volume::StandardLabels()[label].name);
    }
    return names;
  }

  testing_support::TemporaryFolder folder;
  volume::CtVolume ct;
  volume::LabelMap labels;
  volume::LabelMap vertebrae;  ///< Of the last maps laid.
  RunContext context;
  std::string warnings;
};

TEST(LayImports, MergesMapsByNameTheLastRemains) {
  RowOfVoxels row;
  row.labels.voxels[5] = volume::LabelOf("bone");
  WriteNiftiLabels(row.folder / "total.nii", 6, 1, 1, {9, 9, 9, 4, 0, 4},
                   {NiftiLabelXml({{9, "pancreas"}, {4, "Spleen"}})});
  WriteNiftiLabels(row.folder / "vessels.nii", 6, 1, 1, {0, 1, 2, 0, 0, 0},
                   {NiftiLabelXml({{1, "liver_vessels"}, {2, "body"}})});
  const std::string report =
      row.Lay({{row.folder / "total.nii", {}}, {row.folder / "vessels.nii", {}}});
  EXPECT_THAT(row.Tissues(), testing::ElementsAre("pancreas", "vessel", "pancreas", "spleen",
                                                  "muscle", "spleen"));  // Bone is no obstacle.
  EXPECT_THAT(report,
              AllOf(HasSubstr("total.nii: 2 structures, by the label table in its header\n"),
                    HasSubstr("vessels.nii: 2 structures")));
}

TEST(LayImports, GasStaysInTheBowelOfAMap) {
  RowOfVoxels row;
  row.labels.voxels[1] = row.labels.voxels[4] = volume::LabelOf("gas");
  WriteNiftiLabels(row.folder / "total.nii", 6, 1, 1, {1, 1, 1, 0, 2, 2},
                   {NiftiLabelXml({{1, "colon"}, {2, "lung_upper_lobe_left"}})});
  row.Lay({{row.folder / "total.nii", {}}});
  EXPECT_THAT(row.Tissues(),
              testing::ElementsAre("bowel", "gas", "bowel", "muscle", "lung", "lung"));
}

TEST(LayImports, NamesOfVertebraeAreKept) {
  RowOfVoxels row;
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {1, 1, 2, 0, 0, 0},
                   {NiftiLabelXml({{1, "vertebrae_L4"}, {2, "sacrum"}})});
  WriteNiftiLabels(row.folder / "b.nii", 6, 1, 1, {0, 0, 0, 7, 0, 0},
                   {NiftiLabelXml({{7, "liver"}})});
  row.Lay({{row.folder / "b.nii", {}}});
  EXPECT_TRUE(row.vertebrae.voxels.empty());
  row.Lay({{row.folder / "a.nii", {}}, {row.folder / "b.nii", {}}});
  const auto label = [](const char* name) {
    return static_cast<volume::Label>(*NumberOfVertebra(name) + 1);
  };
  EXPECT_THAT(row.vertebrae.voxels,
              testing::ElementsAre(label("L4"), label("L4"), label("S1"), 0, 0, 0));
}

TEST(LayImports, NamesAreThoseOfTheFileWhateverItsNumbersAre) {
  RowOfVoxels row;
  // 5 is the liver in version 2 of TotalSegmentator, here it is not.
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {5, 0, 0, 0, 0, 0},
                   {NiftiLabelXml({{5, "pancreas"}})});
  row.Lay({{row.folder / "a.nii", {}}});
  EXPECT_EQ(row.Tissues()[0], "pancreas");
  EXPECT_EQ(row.warnings, "");
  EXPECT_THAT(
      [&] {
        row.Lay(
            {{row.folder / "a.nii", ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json"}});
      },
      ThrowsMessage<InputError>(HasSubstr("value 5 is 'pancreas' for the file, but 'liver'")));
}

TEST(LayImports, AssumesATableOnlyWithAWarning) {
  RowOfVoxels row;
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {7, 5, 0, 0, 0, 0}, {});
  const std::string report = row.Lay({{row.folder / "a.nii", {}}});
  EXPECT_EQ(row.Tissues()[0], "pancreas");
  EXPECT_THAT(report, HasSubstr("by the values of totalsegmentator.json"));
  EXPECT_THAT(row.warnings, HasSubstr("those of totalsegmentator.json are assumed"));
}

TEST(LayImports, AsksForTheNameOfAMaskOfOneValue) {
  RowOfVoxels row;
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {7, 0, 0, 0, 0, 0}, {});
  EXPECT_THAT(
      [&] {
        row.Lay({{row.folder / "a.nii", {}}});
      },
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("has one value, 7, and no name for it"), HasSubstr("--mapping"))));
}

TEST(LayImports, AsksWhichNameOfAMaskIsRightWhereATableBesideItHasAnother) {
  RowOfVoxels row;
  WriteNiftiLabels(row.folder / "liver.nii", 6, 1, 1, {1, 0, 0, 0, 0, 0}, {});
  const auto lay = [&] { return row.Lay({{row.folder / "liver.nii", {}}}); };
  WriteTextFile(row.folder / "labels.txt", "  1  255 0 0  1 1 1  \"liver\"\n");
  EXPECT_THAT(lay(), HasSubstr("by labels.txt"));
  WriteTextFile(row.folder / "labels.txt", "  1  255 0 0  1 1 1  \"spleen\"\n");
  EXPECT_THAT(lay, ThrowsMessage<InputError>(
                       HasSubstr("by labels.txt it is 'spleen', by the file's name 'liver'")));
}

TEST(LayImports, ListsNamesThatItDoesNotHave) {
  RowOfVoxels row;
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {1, 2, 3, 4, 0, 0},
                   {NiftiLabelXml({{1, "splen"}, {2, "Segment_2"}, {4, "liver"}})});
  EXPECT_THAT(
      [&] {
        row.Lay({{row.folder / "a.nii", {}}});
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("'splen' (1), like 'spleen'?"),
                                      HasSubstr("'Segment_2' (2)"), HasSubstr("'no name' (3)"),
                                      HasSubstr("--mapping"))));
  WriteTextFile(row.folder / "mine.json", R"({"format": "acus-label-names/1", "structures": [
      {"names": ["splen"], "tissue": "spleen"}, {"names": ["segment 2"], "tissue": "outside"}]})");
  WriteNiftiLabels(row.folder / "a.nii", 6, 1, 1, {1, 2, 0, 0, 0, 0},
                   {NiftiLabelXml({{1, "splen"}, {2, "Segment_2"}})});
  row.Lay({{row.folder / "a.nii", row.folder / "mine.json"}});
  EXPECT_EQ(row.Tissues()[0], "spleen");
  EXPECT_EQ(row.Tissues()[1], "muscle");
  WriteNiftiLabels(row.folder / "b.nii", 6, 1, 1, {1, 2, 0, 0, 0, 0}, {});
  EXPECT_THAT(
      [&] {
        row.Lay({{row.folder / "b.nii", row.folder / "mine.json"}});
      },
      ThrowsMessage<InputError>(HasSubstr("mine.json cannot be used")));
}

TEST(LayImports, BoneThatACompleteMapDoesNotHaveGoes) {
  RowOfVoxels row;
  for (const std::size_t n : {std::size_t{1}, std::size_t{2}}) {
    row.labels.voxels[n] = volume::LabelOf("bone");
    row.ct.voxels[n] = 400;
  }
  WriteNiftiLabels(row.folder / "some.nii", 6, 1, 1, {0, 0, 1, 0, 0, 0},
                   {NiftiLabelXml({{1, "vertebrae_L3"}})});
  row.Lay({{row.folder / "some.nii", {}}});
  EXPECT_EQ(row.Tissues()[1], "bone");  // The map lists one bone only.
  WriteNiftiLabels(row.folder / "all.nii", 6, 1, 1, {0, 0, 1, 0, 0, 0},
                   {NiftiLabelXml({{1, "bone"}})});
  row.Lay({{row.folder / "all.nii", {}}});
  EXPECT_EQ(row.Tissues()[1], "soft_tissue");
  EXPECT_EQ(row.Tissues()[2], "bone");
}

TEST(LayImports, SaysWhereTheTwoLieIfTheyDoNotMeet) {
  RowOfVoxels row;
  row.ct.geometry.origin_mm[2] += 500.0;
  row.labels.geometry = row.ct.geometry;
  WriteNiftiLabels(row.folder / "liver.nii", 6, 1, 1, {1, 0, 0, 0, 0, 0}, {});
  EXPECT_THAT(
      [&] {
        row.Lay({{row.folder / "liver.nii", {}}});
      },
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("z 0 to 0 mm, the CT"), HasSubstr("z 500 to 500 mm"))));
}

}  // namespace
}  // namespace acus::segmentation
