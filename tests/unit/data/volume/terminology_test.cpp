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

}  // namespace
}  // namespace acus::volume
