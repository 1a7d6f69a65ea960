#include "acus/data/volume/terminology.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/data/volume/segment_keys.h"

namespace acus::volume {
namespace {

TEST(Terminology, IsWrittenAsSlicerWritesIt) {
  EXPECT_EQ(TerminologyEntry("liver"),
            "Segmentation category and type - 3D Slicer General Anatomy list"
            "~SCT^123037004^Anatomical Structure~SCT^10200004^Liver"
            "~^^~Anatomic codes - DICOM master list~^^~^^");
  EXPECT_EQ(TerminologyEntry("vessel"),
            "Segmentation category and type - DICOM master list"
            "~SCT^85756007^Tissue~SCT^59820001^Blood vessel"
            "~^^~Anatomic codes - DICOM master list~^^~^^");
}

TEST(Terminology, EveryStandardLabelAndAnyNameHasSevenFieldsWithoutASeparatorOfTags) {
  const auto expect_entry = [](std::string_view name) {
    const std::string entry = TerminologyEntry(name);
    EXPECT_EQ(std::ranges::count(entry, '~'), 6) << entry;
    EXPECT_EQ(entry.find_first_of("|:"), entry.npos) << entry;
  };
  for (const StandardLabel& label : StandardLabels()) expect_entry(label.name);
  expect_entry("a|segment~of^a:user");
}

TEST(Terminology, IsATagOfEachSegment) {
  Grid<Label> labels(Geometry{.size = {2, 1, 1}});
  labels.voxels = {8, 200};
  const auto keys = SegmentKeys(labels, {{8, "liver"}, {200, "duct"}});
  EXPECT_EQ(keys.at("Segment0_Tags"),
            "Segmentation.Status:inprogress|TerminologyEntry:" + TerminologyEntry("liver") + "|");
  EXPECT_NE(keys.at("Segment1_Tags").find("~SCT^85756007^Tissue~SCT^85756007^Tissue~"),
            std::string::npos);
}

TEST(Terminology, OfASegmentIsReadWithTypeRegionAndSide) {
  const ValueName own = TermsFrom("a:b|TerminologyEntry:" + TerminologyEntry("liver") + "|");
  EXPECT_EQ(own.codes, std::vector<std::string>{"10200004"});
  EXPECT_EQ(own.side, "");
  const ValueName kidney = TermsFrom(
      "TerminologyEntry:List~SCT^123037004^Anatomical Structure~SCT^64033007^Kidney"
      "~SCT^7771000^Left~Regions~SCT^818983003^Abdomen~^^|Segmentation.Status:completed|");
  EXPECT_EQ(kidney.codes, (std::vector<std::string>{"64033007", "818983003"}));
  EXPECT_EQ(kidney.side, "left");
  EXPECT_TRUE(TermsFrom("Segmentation.Status:completed|").codes.empty());
  EXPECT_TRUE(TermsFrom("TerminologyEntry:one~two").codes.empty());
  // Codes of other lists may have the same text.
  EXPECT_TRUE(
      TermsFrom("TerminologyEntry:List~99X^1^A~99X^64033007^Kidney~^^~R~^^~^^|").codes.empty());
  EXPECT_EQ(TermsFrom("TerminologyEntry:List~SRT^T-D0050^Tissue~SRT^T-71000^Kidney~SRT^G-A100^Right"
                      "~R~^^~^^|")
                .side,
            "right");
}

TEST(SegmentsFromKeys, HaveLayerNameAndCodes) {
  const auto segments =
      SegmentsFromKeys({{"Segment0_LabelValue", "300"},
                        {"Segment0_Name", "Segment_1"},
                        {"Segment0_Layer", "1"},
                        {"Segment0_Tags", "TerminologyEntry:L~SCT^1^c~SCT^2^t~^^"},
                        {"Segment1_LabelValue", "2"},
                        {"Segment1_Name", "liver"},
                        {"Segment2_LabelValue", "nothing"},
                        {"Segment2_Name", "spleen"}},
                       "s.nrrd");
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[0].layer, 1);
  EXPECT_EQ(segments[0].value, 300);
  EXPECT_EQ(segments[0].name.text, "Segment_1");
  EXPECT_EQ(segments[0].name.codes, std::vector<std::string>{"2"});
  EXPECT_EQ(segments[1].layer, 0);
  EXPECT_EQ(segments[1].name.text, "liver");
  EXPECT_TRUE(segments[1].name.codes.empty());
}

}  // namespace
}  // namespace acus::volume
