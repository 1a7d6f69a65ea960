#include "acus/data/volume/nifti_label_table.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/data/volume/named_values.h"
#include "support/nifti_writer.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::NiftiLabelXml;
using testing_support::WriteNiftiLabels;

TEST(NiftiLabelTable, IsFoundAmongOtherExtensions) {
  const testing_support::TemporaryFolder folder;
  WriteNiftiLabels(folder / "a.nii", 2, 1, 1, {0, 7},
                   {"a comment", NiftiLabelXml({{0, "???"}, {7, "kidney_left"}, {300, "a & b"}})});
  const ValueNames names = NiftiLabelTable(folder / "a.nii");
  ASSERT_EQ(names.size(), 2U);
  EXPECT_EQ(names.at(7).text, "kidney_left");
  EXPECT_EQ(names.at(300).text, "a & b");
  const NamedValues map = ReadNamedValues(folder / "a.nii");
  EXPECT_EQ(map.values.voxels, (std::vector<std::int32_t>{0, 7}));
  EXPECT_EQ(map.names.size(), 2U);
  EXPECT_EQ(map.named_by, "by the label table in its header");
}

TEST(NiftiLabelTable, IsEmptyWithoutOneAndRefusedIfBroken) {
  const testing_support::TemporaryFolder folder;
  WriteNiftiLabels(folder / "none.nii", 2, 1, 1, {0, 7}, {});
  EXPECT_TRUE(NiftiLabelTable(folder / "none.nii").empty());
  EXPECT_EQ(ReadNamedValues(folder / "none.nii").named_by, "");
  WriteNiftiLabels(folder / "cut.nii", 2, 1, 1, {0, 7}, {"<CaretExtension><LabelTable><Label"});
  EXPECT_THAT([&] { NiftiLabelTable(folder / "cut.nii"); },
              ThrowsMessage<InputError>(HasSubstr("cut.nii (label table in its header)")));
  WriteNiftiLabels(folder / "key.nii", 2, 1, 1, {0, 7},
                   {"<LabelTable><Label Key='one'>liver</Label></LabelTable>"});
  EXPECT_THAT([&] { NiftiLabelTable(folder / "key.nii"); },
              ThrowsMessage<InputError>(HasSubstr("the Key 'one' of label 'liver'")));
}

}  // namespace
}  // namespace acus::volume
