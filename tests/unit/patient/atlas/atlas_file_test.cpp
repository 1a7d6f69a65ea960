#include "acus/patient/atlas/atlas_file.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "support/temporary_folder.h"

namespace acus::atlas {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::TemporaryFolder;

TEST(AtlasFile, AFileThatIsMissingIsNamedWithItsPlace) {
  const TemporaryFolder folder;
  RunContext context;
  WriteTextFile(folder / "atlas.json", R"({"format": "acus-atlas/1", "patients": [{"name": "one",
    "ct": "none.nrrd", "labels": "none.seg.nrrd"}]})");
  EXPECT_THAT([&] { ReadAtlas(folder.path(), context); },
              ThrowsMessage<InputError>(
                  testing::AllOf(HasSubstr("/patients/0/ct"), HasSubstr("does not exist"))));
}

TEST(AtlasFile, PathsStartAtTheFolder) {
  const TemporaryFolder folder;
  RunContext context;
  WriteTextFile(folder / "a.nrrd", "x");
  WriteTextFile(folder / "atlas.json", R"({"format": "acus-atlas/1", "patients": [{"name": "one",
    "ct": "a.nrrd", "labels": "a.nrrd"}]})");
  const auto patients = ReadAtlas(folder.path(), context);
  ASSERT_EQ(patients.size(), 1U);
  EXPECT_EQ(patients[0].ct, folder / "a.nrrd");
  EXPECT_EQ(patients[0].labels.file, folder / "a.nrrd");
  EXPECT_TRUE(patients[0].labels.mapping.empty()) << "found as for a map of --import";
  EXPECT_TRUE(ReadAtlas({}, context).empty());
}

}  // namespace
}  // namespace acus::atlas
