#include "acus/data/volume/named_values.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// 4 x 1 x 1 voxels in two layers, as 3D Slicer writes segments that overlap.
std::string TwoLayers(const std::string& fields) {
  std::string text =
      "NRRD0004\ntype: unsigned char\ndimension: 4\nspace: left-posterior-superior\n"
      "sizes: 2 4 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
      "kinds: list domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n" +
      fields + "\n";
  for (const int value : {1, 0, 1, 1, 1, 0, 2, 0}) text += static_cast<char>(value);
  return text;
}

TEST(NamedValues, MergeLayersWithTheSmallerSegmentOnTop) {
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder / "s.seg.nrrd",
                TwoLayers("Segment0_LabelValue:=1\nSegment0_Layer:=1\nSegment0_Name:=tumour\n"
                          "Segment1_LabelValue:=1\nSegment1_Layer:=0\nSegment1_Name:=liver\n"
                          "Segment2_LabelValue:=2\nSegment2_Layer:=0\nSegment2_Name:=spleen\n"));
  const NamedValues map = ReadNamedValues(folder / "s.seg.nrrd");
  EXPECT_THAT(map.values.voxels, ElementsAre(2, 1, 2, 3));
  EXPECT_EQ(map.names.at(1).text, "tumour");
  EXPECT_EQ(map.names.at(2).text, "liver");
  EXPECT_EQ(map.names.at(3).text, "spleen");
  EXPECT_EQ(map.named_by, "by the names of its segments");
}

TEST(NamedValues, RefuseLayersWithoutSegmentsOrBeyondTheFile) {
  const testing_support::TemporaryFolder folder;
  const auto refuses = [&](const std::string& fields, const char* message) {
    WriteTextFile(folder / "s.seg.nrrd", TwoLayers(fields));
    EXPECT_THAT([&] { ReadNamedValues(folder / "s.seg.nrrd"); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refuses("", "has 2 values for each voxel and no segments");
  refuses("Segment0_LabelValue:=1\nSegment0_Layer:=2\nSegment0_Name:=liver\n",
          "segment 'liver' is in layer 2, but there are 2");
}

TEST(NamedValues, AreThoseOfTheGroupsOfMitk) {
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder / "s.nrrd",
                TwoLayers("modality:=org.mitk.multilabel.segmentation\n"
                          "org.mitk.multilabel.segmentation.labelgroups:="
                          R"([{"labels": [{"name": "liver", "value": 1, "color": [1, 0, 0]},)"
                          R"( {"name": "spleen", "value": 2}]}, {"labels": [{"name": "tumour",)"
                          R"( "value": 1}]}])"
                          "\n"));
  const NamedValues map = ReadNamedValues(folder / "s.nrrd");
  EXPECT_THAT(map.values.voxels, ElementsAre(1, 3, 1, 2));
  EXPECT_EQ(map.names.at(2).text, "spleen");
  EXPECT_EQ(map.names.at(3).text, "tumour");

  // Before 2023: an XML text for each label.
  const std::string name = "<property key=\"name\" type=\"StringProperty\"><string value=\"";
  const std::string value =
      "\"/></property>\\n<property key=\"value\" type=\"UIntProperty\"><unsigned value=\"";
  const std::string begin = "<?xml version=\"1.0\"?>\\n<Label version=\"1\">\\n",
                    end = "\"/></property></Label>\n";
  WriteTextFile(
      folder / "old.nrrd",
      TwoLayers("modality:=org.mitk.image.multilabel\nlayers:=2\nlayer_000:=3\n"
                "org_mitk_label_000_00000:=" +
                begin + name + "Exterior" + value + "0" + end +
                "org_mitk_label_000_00001:=" + begin + name + "liver" + value + "1" + end +
                "org_mitk_label_000_00002:=" + begin + name + "spleen" + value + "2" + end +
                "org_mitk_label_001_00001:=" + begin + name + "tumour" + value + "1" + end));
  const NamedValues old = ReadNamedValues(folder / "old.nrrd");
  EXPECT_THAT(old.values.voxels, ElementsAre(1, 3, 1, 2));
  EXPECT_EQ(old.names.at(1).text, "liver");

  WriteTextFile(folder / "broken.nrrd",
                TwoLayers("org.mitk.multilabel.segmentation.labelgroups:=[{\"labels\": [{}]}]\n"));
  EXPECT_THAT(
      [&] { ReadNamedValues(folder / "broken.nrrd"); },
      ThrowsMessage<InputError>(HasSubstr("label groups of MITK in its header are broken")));
}

}  // namespace
}  // namespace acus::volume
