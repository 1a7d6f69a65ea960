// Reads every real CT of the public data sets.
#include <algorithm>
#include <gmock/gmock.h>

#include "acus/data/volume/volume_io.h"
#include "support/shared_data.h"

namespace acus::volume {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

#define ACUS_DATA(variable, name)                          \
  const auto variable = testing_support::SharedData(name); \
  if (!variable) GTEST_SKIP() << "test data " << (name) << " is not here"

RunContext TwoThreads() {
  RunContext context;
  context.num_threads = 2;
  return context;
}

TEST(RealCt, IrcadFolderOfFilesWithoutExtension) {
  ACUS_DATA(folder, "ct/ircadb01_dicom");
  const CtVolume ct = ReadCt(*folder, "", TwoThreads());
  EXPECT_TRUE((ct.geometry.size == Eigen::Array3i(512, 512, 129)).all());
  EXPECT_NEAR(ct.geometry.spacing_mm[0], 0.57, 0.005);
  EXPECT_NEAR(ct.geometry.spacing_mm[2], 1.6, 1e-6);
  EXPECT_EQ(std::ranges::min(ct.voxels), -1024);
}

TEST(RealCt, ThoraxImplicitLittleEndian) {
  ACUS_DATA(folder, "ct/thorax_dicom");
  const CtVolume ct = ReadCt(*folder, "", TwoThreads());
  EXPECT_TRUE((ct.geometry.size == Eigen::Array3i(512, 512, 141)).all());
  EXPECT_NEAR(ct.geometry.spacing_mm[2], 2.0, 1e-6);
  EXPECT_NEAR(ct.geometry.origin_mm[0], -250.0, 1e-6);
}

TEST(RealCt, Jpeg2000SeriesWithoutUidOrPreparedNames) {
  ACUS_DATA(folder, "ct/totalseg/example_ct_dicom");
  const CtVolume ct = ReadCt(*folder, "", TwoThreads());
  EXPECT_TRUE((ct.geometry.size == Eigen::Array3i(512, 512, 20)).all());
  EXPECT_EQ(std::ranges::min(ct.voxels), -1024);
  EXPECT_GT(std::ranges::max(ct.voxels), 300);
}

TEST(RealCt, NiftiAndItsLabelsLieOnOneGrid) {
  ACUS_DATA(ct_file, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(label_file, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const CtVolume ct = ReadCt(*ct_file, "", RunContext{});
  const auto labels = ReadIntegerVolume(*label_file);
  EXPECT_TRUE(ct.geometry.Matches(labels.geometry));
  EXPECT_GT(ct.geometry.direction.determinant(), 0.0);
}

TEST(RealCt, IrcadLabelsInVti) {
  ACUS_DATA(file, "ct/ircadb01_labels.vti");
  const auto labels = ReadIntegerVolume(*file);
  EXPECT_TRUE((labels.geometry.size == Eigen::Array3i(512, 512, 129)).all());
  EXPECT_EQ(std::ranges::max(labels.voxels), 513);
}

TEST(RealCt, BlocksOfATiltedHeadScanAreOfferedByName) {
  ACUS_DATA(folder, "ct/dicom_traps_ge");
  EXPECT_THAT([&] { ReadCt(*folder, "", RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("2 series look like a CT")));
}

}  // namespace
}  // namespace acus::volume
