#include "acus/data/volume/label_table.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/names_beside.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
using testing::ThrowsMessage;

class LabelTable : public testing::Test {
 protected:
  std::map<std::int32_t, std::string> Read(const std::string& text,
                                           const char* name = "labels.txt") {
    WriteTextFile(folder_ / name, text);
    std::map<std::int32_t, std::string> texts;
    for (const auto& [value, entry] : NamesInTable(folder_ / name)) texts[value] = entry.text;
    return texts;
  }
  const testing_support::TemporaryFolder folder_;
};

TEST_F(LabelTable, IsALabelDescriptionOfItkSnap) {
  const std::string head =
      "################################################\n# ITK-SnAP Label Description File\n"
      "# IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL\n";
  EXPECT_THAT(Read(head + "    0     0    0    0        0  0  0    \"Clear Label\"\n"
                          "    1   255    0    0        1  1  1    \"liver\"\r\n"
                          "   17     0  255    0      0.5  1  0    \"Kidney, left 2\"\n\n"),
              ElementsAre(Pair(1, "liver"), Pair(17, "Kidney, left 2")));
  EXPECT_THAT(
      [&] { Read(head + "1 255 0 0 1 1 1 \"liver\"\n2 0 255 0 1 1 1\n"); },
      ThrowsMessage<InputError>(HasSubstr("labels.txt:5: '2 0 255 0 1 1 1' names no value")));
  EXPECT_THAT([&] { Read(head + "1 255 0 0 1 1 1 \"liver\"\n1 0 0 0 1 1 1 \"spleen\"\n"); },
              ThrowsMessage<InputError>(HasSubstr("value 1 is 'liver' and 'spleen'")));
}

TEST_F(LabelTable, IsAColourTableOf3DSlicerOrFreeSurfer) {
  EXPECT_THAT(Read("# Color table file /a/b.ctbl\n# 3 values\n0 Background 0 0 0 0\n"
                   "1 kidney_left 216 101 79 255\n2 bone 241 214 145 255 and more\n",
                   "a.ctbl"),
              ElementsAre(Pair(1, "kidney_left"), Pair(2, "bone")));
  EXPECT_THAT(Read("#No. Label Name:      R   G   B   A\n\n0   Unknown   0   0   0   0\n"
                   "41  Right-Lung   10  20  30  0\n7\trib left 1\t10\t20\t30\t0\n"),
              ElementsAre(Pair(7, "rib left 1"), Pair(41, "Right-Lung")));
  EXPECT_THAT(Read("# Color procedural file /a.txt\n0 0 0 0\n63 0 0.5 0.4\n"), IsEmpty());
}

TEST_F(LabelTable, IsAList) {
  EXPECT_THAT(
      Read("1 liver\n2: Left Kidney\n3,spleen\n4 = rib 7\n"),
      ElementsAre(Pair(1, "liver"), Pair(2, "Left Kidney"), Pair(3, "spleen"), Pair(4, "rib 7")));
  EXPECT_THAT(Read("A note of 2024.\n1 biopsy was taken\n"), IsEmpty());
  EXPECT_THAT(Read("1 biopsy was taken\nthen the patient left\n"), IsEmpty());
  EXPECT_THAT(Read(""), IsEmpty());
}

TEST_F(LabelTable, HasColumns) {
  EXPECT_THAT(Read("index\tname\tabbreviation\n0\tbackground\tBG\n5\tliver\tL\n", "a.tsv"),
              ElementsAre(Pair(5, "liver")));
  WriteTextFile(folder_ / "a.csv",
                "LabelValue,Name,Color_R,Color_G,Color_B,Type_CodingScheme,Type_CodeValue,"
                "TypeModifier_CodingScheme,TypeModifier_CodeValue\n"
                "5,one,1,2,3,SCT,64033007,SCT,7771000\n6,two,1,2,3,99X,1,,\n");
  const ValueNames names = NamesInTable(folder_ / "a.csv");
  EXPECT_EQ(names.at(5).codes, std::vector<std::string>{"64033007"});
  EXPECT_EQ(names.at(5).side, "left");
  EXPECT_THAT(names.at(6).codes, IsEmpty());
  // Other tables of the same name are passed over, whatever is wrong with them.
  EXPECT_THAT(Read("time_s,force_n\n0,1\n1,2\n", "b.csv"), IsEmpty());
  EXPECT_THAT(Read("-1.5,2.5\n0,1\n", "b.csv"), IsEmpty());
  EXPECT_THAT(Read("volume_ml,mean\nliver\n", "b.csv"), IsEmpty());
  EXPECT_THAT([&] { Read("index,name\n1.5,liver\n", "c.csv"); },
              ThrowsMessage<InputError>(HasSubstr("index is 1.5; a whole number is needed")));
}

TEST_F(LabelTable, IsReadOrRefusedWhereItIsDamaged) {
  const std::pair<const char*, const char*> files[] = {
      {"a.txt",
       "# ITK-SnAP Label Description File\n1 255 0 0 1 1 1 \"liver\"\n2 0 9 0 1 1 1 \"l\"\n"},
      {"a.ctbl", "# Color table file a\n0 Background 0 0 0 0\n1 liver 221 130 101 255\n"},
      {"a.csv", "LabelValue,Name,Type_CodingScheme,Type_CodeValue\n1,liver,SCT,10200004\n"},
      {"a.json", R"({"labels": {"background": 0, "liver": 1, "spleen": 2}})"},
      {"b.json", R"({"type": "t", "groups": [{"labels": [{"name": "liver", "value": 1}]}]})"}};
  for (const auto& [name, text] : files) {
    const auto path = folder_ / name;
    const int refused =
        testing_support::ReadDamagedCopies(text, path, 300, [&] { NamesInFile(path); });
    EXPECT_GT(refused, 0) << name;
  }
}

}  // namespace
}  // namespace acus::volume
