#include "acus/patient/segmentation/import/foreign_map.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/dicom_segmentation_writer.h"
#include "support/nifti_writer.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::NiftiLabelXml;
using testing_support::WriteNiftiLabels;

std::string NameIn(const volume::NamedValues& map, std::int32_t value) {
  const auto found = map.names.find(value);
  return found == map.names.end() ? "" : found->second.text;
}

TEST(ForeignMap, TakesNamesFromAFileBesideIt) {
  const testing_support::TemporaryFolder folder;
  const fs::path inside = folder / "labelsTr";
  fs::create_directory(inside);
  WriteNiftiLabels(inside / "case.nii", 2, 1, 1, {0, 7}, {});
  EXPECT_TRUE(ReadForeignMap(inside / "case.nii", {}).names.empty());

  WriteTextFile(folder / "dataset.json",
                R"({"name": "nnU-Net", "labels": {"background": 0, "liver": 7}})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "liver");
  EXPECT_EQ(ReadForeignMap(inside / "case.nii", {}).named_by, "by dataset.json");

  WriteTextFile(inside / "metadata.json", R"({"network_data_format": {"outputs": {"pred":
      {"channel_def": {"0": "background", "7": "spleen"}}}}})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "spleen");

  WriteTextFile(inside / "case.json", R"({"labels": {"7": "pancreas"}})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "pancreas");
  WriteTextFile(inside / "case.json", R"({"7": "aorta"})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "aorta");
  WriteTextFile(inside / "case.json", R"({"segmentAttributes": [[{"labelID": 7, "SegmentLabel": "x",
      "SegmentedPropertyTypeCodeSequence": {"CodeValue": "64033007"},
      "SegmentedPropertyTypeModifierCodeSequence": {"CodeValue": "7771000"}}]]})");
  const auto dcmqi = ReadForeignMap(inside / "case.nii", {});
  EXPECT_EQ(dcmqi.names.at(7).codes, std::vector<std::string>{"64033007"});
  EXPECT_EQ(dcmqi.names.at(7).side, "left");

  // A description of something else is passed over, a value with two names is not.
  WriteTextFile(inside / "case.json", R"({"EchoTime": 0.1, "Manufacturer": "x"})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "spleen");
  WriteTextFile(inside / "case.json", R"({"labels": {"liver": 7, "spleen": 7}})");
  EXPECT_THAT([&] { ReadForeignMap(inside / "case.nii", {}); },
              ThrowsMessage<InputError>(HasSubstr("case.json: value 7 is 'liver' and 'spleen'")));

  // Regions of nnU-Net have no single value; names without values are of no use.
  WriteTextFile(inside / "case.json", R"({"labels": {"background": 0, "whole": [1, 2]}})");
  EXPECT_THAT([&] { ReadForeignMap(inside / "case.nii", {}); },
              ThrowsMessage<InputError>(HasSubstr("'whole' is a region of the values [1,2]")));
  WriteTextFile(inside / "case.json", R"({"labels": ["background", "liver"]})");
  EXPECT_THAT([&] { ReadForeignMap(inside / "case.nii", {}); },
              ThrowsMessage<InputError>(HasSubstr("a list of names without values")));
  WriteTextFile(inside / "case.json", R"({"labels": [{"value": 7, "name": "colon"}]})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "colon");
  WriteTextFile(inside / "case.json", R"({"7": {"name": "stomach", "color": [1, 2, 3]}})");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "stomach");

  // Label descriptions and colour tables.
  WriteTextFile(inside / "case_ColorTable.ctbl", "7 bladder 1 2 3 255\n");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "bladder");
  WriteTextFile(inside / "case.txt", "7 1 2 3 1 1 1 \"trachea\"\n");
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "trachea");
  EXPECT_EQ(ReadForeignMap(inside / "case.nii", {}).named_by, "by case.txt");

  // What the file says itself goes first.
  WriteNiftiLabels(inside / "case.nii", 2, 1, 1, {0, 7}, {NiftiLabelXml({{7, "heart"}})});
  EXPECT_EQ(NameIn(ReadForeignMap(inside / "case.nii", {}), 7), "heart");
}

TEST(ForeignMap, TakesNamesFromLabelsTxtAndTheStackOfMitkInItsFolder) {
  const testing_support::TemporaryFolder folder;
  WriteNiftiLabels(folder / "case.nii", 2, 1, 1, {0, 7}, {});
  const std::string head = R"({"type": "org.mitk.multilabel.segmentation.stack", "groups": [)";
  WriteTextFile(folder / "other.mitklabel.json",
                head + R"({"_file": "./x.nii", "labels": [{"name": "liver", "value": 7}]}]})");
  EXPECT_TRUE(ReadForeignMap(folder / "case.nii", {}).names.empty());
  WriteTextFile(folder / "s.mitklabel.json",
                head + R"({"_file": "./case.nii", "labels": [{"name": "spleen", "value": 7}]}]})");
  EXPECT_EQ(NameIn(ReadForeignMap(folder / "case.nii", {}), 7), "spleen");
  WriteTextFile(folder / "s.mitklabel.json",
                head + R"({"labels": [{"name": "heart", "value": 3, "_file": "./case.nii",)" +
                    R"( "_file_value": 7}]}]})");
  EXPECT_EQ(NameIn(ReadForeignMap(folder / "case.nii", {}), 7), "heart");
  WriteTextFile(folder / "labels.txt", "7 255 0 0 1 1 1 \"pancreas\"\n");
  EXPECT_EQ(NameIn(ReadForeignMap(folder / "case.nii", {}), 7), "pancreas");
}

TEST(ForeignMap, OfAFolderHasTheSmallerMaskOnTop) {
  const testing_support::TemporaryFolder folder;
  WriteNiftiLabels(folder / "aorta.nii", 4, 1, 1, {0, 0, 0, 0}, {});
  WriteNiftiLabels(folder / "lesion.nii", 4, 1, 1, {0, 1, 0, 0}, {});
  WriteNiftiLabels(folder / "liver.nii", 4, 1, 1, {255, 255, 255, 0}, {});
  WriteTextFile(folder / "notes.txt", "not a mask");
  const auto map = ReadForeignMap(folder / ".", {});
  ASSERT_EQ(map.names.size(), 3U);
  EXPECT_EQ(NameIn(map, map.values.voxels[0]), "liver");
  EXPECT_EQ(NameIn(map, map.values.voxels[1]), "lesion");
  EXPECT_EQ(NameIn(map, map.values.voxels[2]), "liver");
  EXPECT_EQ(map.values.voxels[3], 0);
  EXPECT_EQ(NameIn(map, 1), "aorta");

  WriteNiftiLabels(folder / "spleen.nii", 4, 1, 1, {0, 0, 1, 2}, {});
  EXPECT_THAT([&] { ReadForeignMap(folder / ".", {}); },
              ThrowsMessage<InputError>(HasSubstr("spleen.nii: has the values 1 and 2")));
  WriteNiftiLabels(folder / "spleen.nii", 2, 2, 1, {0, 0, 1, 1}, {});
  EXPECT_THAT(
      [&] { ReadForeignMap(folder / ".", {}); },
      ThrowsMessage<InputError>(HasSubstr("spleen.nii: lies on another grid than aorta.nii")));
}

TEST(ForeignMap, OfAFolderMayBeASegmentationObject) {
  const testing_support::TemporaryFolder folder;
  EXPECT_THAT(
      [&] { ReadForeignMap(folder / ".", {}); },
      ThrowsMessage<InputError>(HasSubstr("holds 0 DICOM segmentations or structure sets")));
  testing_support::DicomSegObject object;
  object.segments = {{.label = "Liver", .code = "10200004", .side_code = ""}};
  object.frames = {{1, {0, 0, 0}, {1, 0, 0, 0, 0, 0, 0, 0, 1}}};
  WriteDicomSegmentation(folder / "segmentations.dcm", object);
  EXPECT_EQ(NameIn(ReadForeignMap(folder / ".", {}), 1), "Liver");
}

}  // namespace
}  // namespace acus::segmentation
