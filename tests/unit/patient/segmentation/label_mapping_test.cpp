#include "acus/patient/segmentation/import/label_mapping.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/import/imported_labels.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

volume::LabelMap Foreign() {
  volume::Geometry g;
  g.size = {6, 6, 6};
  g.spacing_mm = {2, 2, 2};
  volume::LabelMap labels(g);
  labels.At(1, 2, 3) = 5;
  labels.At(4, 4, 4) = 29;
  return labels;
}

LabelMapping TotalSegmentator() {
  return ReadLabelMapping(ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json");
}

TEST(LabelMapping, TotalSegmentatorHasAllItsClasses) {
  const LabelMapping mapping = TotalSegmentator();
  EXPECT_EQ(mapping.tissue.size(), 117U);
  EXPECT_EQ(mapping.name.at(5), "liver");
  EXPECT_EQ(mapping.tissue.at(5), volume::LabelOf("liver"));
  EXPECT_EQ(mapping.name.at(29), "vertebrae_L3");
  EXPECT_EQ(mapping.tissue.at(29), volume::LabelOf("bone"));
  EXPECT_EQ(mapping.tissue.at(117), volume::LabelOf("cartilage"));
}

TEST(LabelMapping, OurOwnMapsHaveEveryStandardLabelAsItIs) {
  const LabelMapping mapping = ReadLabelMapping(ACUS_SOURCE_DIR "/configs/label_maps/acus.json");
  EXPECT_TRUE(mapping.covers_body);
  EXPECT_EQ(mapping.tissue.size(), volume::StandardLabels().size() - 1);
  for (const auto& [value, tissue] : mapping.tissue) {
    EXPECT_EQ(value, tissue);
    EXPECT_EQ(volume::StandardLabels()[tissue].name, mapping.name.at(value));
  }
}

/// By the values of TotalSegmentator.
volume::LabelMap Imported(const std::filesystem::path& file, const volume::Geometry& grid) {
  return TissuesIn(ReadImportedLabels(
      {.file = file, .mapping = ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json"}, grid,
      RunContext{}));
}

TEST(ImportLabels, TranslatesOnTheSameGridAndOnAFinerOne) {
  const testing_support::TemporaryFolder folder;
  WriteLabelMap(folder / "f.seg.nrrd", Foreign());
  const auto same = Imported(folder / "f.seg.nrrd", Foreign().geometry);
  EXPECT_EQ(same.At(1, 2, 3), volume::LabelOf("liver"));
  EXPECT_EQ(same.At(4, 4, 4), volume::LabelOf("bone"));
  volume::Geometry fine = Foreign().geometry;
  fine.size = {12, 12, 12};
  fine.spacing_mm = {1, 1, 1};
  fine.origin_mm.setConstant(-0.5);
  const auto finer = Imported(folder / "f.seg.nrrd", fine);
  EXPECT_EQ(finer.At(2, 4, 6), volume::LabelOf("liver"));
  EXPECT_EQ(finer.At(3, 5, 7), volume::LabelOf("liver"));
  EXPECT_EQ(finer.At(4, 5, 7), 0);
}

TEST(ImportLabels, NamesEveryUnknownValueAndRefusesAnotherPatient) {
  const testing_support::TemporaryFolder folder;
  volume::LabelMap labels = Foreign();
  labels.At(0, 0, 0) = 200;
  labels.At(0, 0, 1) = 201;
  WriteLabelMap(folder / "f.seg.nrrd", labels);
  EXPECT_THAT([&] { Imported(folder / "f.seg.nrrd", labels.geometry); },
              ThrowsMessage<InputError>(HasSubstr("200 201")));
  volume::Geometry away = labels.geometry;
  away.origin_mm = {500, 0, 0};
  EXPECT_THAT([&] { Imported(folder / "f.seg.nrrd", away); },
              ThrowsMessage<InputError>(HasSubstr("does not overlap")));
}

TEST(ReadLabelMapping, RefusesAWrongTissueOrAValueTwice) {
  const testing_support::TemporaryFolder folder;
  const auto refuses = [&](const std::string& rows, const std::string& message) {
    WriteTextFile(folder / "m.json",
                  R"({"format": "acus-label-mapping/1", "labels": [)" + rows + "]}");
    EXPECT_THAT([&] { ReadLabelMapping(folder / "m.json"); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refuses(R"({"value": 1, "name": "x", "tissue": "livr"})", "did you mean 'liver'");
  refuses(
      R"({"value": 1, "name": "x", "tissue": "liver"}, {"value": 1, "name": "y", "tissue": "bone"})",
      "given twice");
  refuses(R"({"value": 0, "name": "x", "tissue": "liver"})", "/labels/0/value");
  refuses("", "/labels");
}

TEST(Overlay, ReplacesOnlyWhereThereIsSomething) {
  volume::LabelMap labels = Foreign();
  volume::LabelMap over(labels.geometry);
  over.At(1, 2, 3) = 8;
  over.names = {{8, "liver"}};
  Overlay(over, labels);
  EXPECT_EQ(labels.At(1, 2, 3), 8);
  EXPECT_EQ(labels.At(4, 4, 4), 29);
  EXPECT_EQ(labels.names.at(8), "liver");
}

}  // namespace
}  // namespace acus::segmentation
