#include "acus/patient/segmentation/voxels/label_names.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/terminology.h"
#include "acus/patient/segmentation/import/label_mapping.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

const LabelNames& Table() {
  static const LabelNames table(ACUS_SOURCE_DIR "/configs/label_maps/names.json");
  return table;
}

std::string TissueOf(const std::string& name) {
  const auto found = Table().Find({.text = name, .codes = {}});
  return found ? std::string(volume::StandardLabels()[found->structure.tissue].name) : "unknown";
}

TEST(LabelNames, HaveTheTissuesOfTheTableOfTotalSegmentatorsValues) {
  const LabelMapping values =
      ReadLabelMapping(ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json");
  ASSERT_EQ(values.name.size(), 117U);
  volume::ValueNames listed;
  for (const auto& [value, name] : values.name) {
    EXPECT_EQ(TissueOf(name), volume::StandardLabels()[values.tissue.at(value)].name) << name;
    listed[value] = {.text = name, .codes = {}};
  }
  EXPECT_TRUE(Table().HasAllBones(listed));
  EXPECT_FALSE(Table().CoversBody(listed));
  listed.erase(91);  // Version 1 had no skull: what is bone in the head is open.
  EXPECT_FALSE(Table().HasAllBones(listed));
}

TEST(LabelNames, HaveEveryStandardTissueByNameAndByItsCode) {
  volume::ValueNames listed;
  for (const volume::StandardLabel& label : volume::StandardLabels()) {
    if (label.label == 0) continue;
    EXPECT_EQ(TissueOf(std::string(label.name)), label.name);
    listed[label.label] = {.text = std::string(label.name), .codes = {}};
    const volume::ValueName term =
        volume::TermsFrom("TerminologyEntry:" + volume::TerminologyEntry(label.name));
    const auto found = Table().Find(term);
    // Some have only the code of "tissue" or "organ", which says nothing.
    if (found) {
      EXPECT_EQ(volume::StandardLabels()[found->structure.tissue].name, label.name);
    }
  }
  EXPECT_TRUE(Table().CoversBody(listed));
  EXPECT_TRUE(Table().HasAllBones(listed));
}

TEST(LabelNames, AreFoundInManySpellings) {
  for (const char* name :
       {"kidney_left", "Left Kidney", "left kidneys", "kidney-left", "KIDNEY LEFT"}) {
    const auto found = Table().Find({.text = name, .codes = {}});
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->structure.name, "kidney");
    EXPECT_EQ(found->side, Side::kLeft);
  }
  EXPECT_EQ(TissueOf("rib_left_7"), "bone");
  EXPECT_EQ(TissueOf("Portal Vein and Splenic Vein"), "vessel");
  EXPECT_EQ(TissueOf("postcava"), "vessel");
  EXPECT_EQ(TissueOf("vertebra L3"), "bone");
  EXPECT_EQ(TissueOf("rectus_abdominis_right"), "muscle");
  EXPECT_EQ(TissueOf("torso_fat"), "fat");
  EXPECT_EQ(TissueOf("body_trunc"), "outside");
  EXPECT_EQ(TissueOf("heart_atrium_left"), "heart");
  EXPECT_EQ(TissueOf("liver_tumor"), "lesion");
  EXPECT_EQ(TissueOf("Segment_1"), "unknown");
  EXPECT_EQ(TissueOf(""), "unknown");
  EXPECT_EQ(Table().Nearest("splen"), "spleen");
}

TEST(LabelNames, AreFoundByCodeWhereTheTextSaysNothing) {
  const auto kidney =
      Table().Find({.text = "Segment_3", .codes = {"1234", "64033007"}, .side = "right"});
  ASSERT_TRUE(kidney);
  EXPECT_EQ(kidney->structure.name, "kidney");
  EXPECT_EQ(kidney->side, Side::kRight);
  const auto named = Table().Find({.text = "spleen", .codes = {"64033007"}});
  EXPECT_EQ(named->structure.name, "spleen");
  EXPECT_FALSE(Table().Find({.text = "Segment_3", .codes = {"85756007"}}));
}

TEST(LabelNames, RefuseANameOrACodeTwiceAndAWrongTissue) {
  const testing_support::TemporaryFolder folder;
  const auto refuses = [&](const std::string& rows, const std::string& message) {
    WriteTextFile(folder / "n.json",
                  R"({"format": "acus-label-names/1", "structures": [)" + rows + "]}");
    EXPECT_THAT([&] { LabelNames table(folder / "n.json"); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refuses(R"({"names": ["a b"], "tissue": "fat"}, {"names": ["B_A"], "tissue": "bone"})",
          "the name 'B_A' is given twice");
  refuses(R"({"names": ["a"], "codes": ["1"], "tissue": "fat"},
             {"names": ["b"], "codes": ["1"], "tissue": "bone"})",
          "the code '1' is given twice");
  refuses(R"({"names": ["a"], "tissue": "livr"})", "did you mean 'liver'");
}

}  // namespace
}  // namespace acus::segmentation
