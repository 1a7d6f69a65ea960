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
  EXPECT_THAT([&] { ReadAtlas({folder.path()}, context); },
              ThrowsMessage<InputError>(
                  testing::AllOf(HasSubstr("/patients/0/ct"), HasSubstr("does not exist"))));
}

TEST(AtlasFile, PathsStartAtTheFolder) {
  const TemporaryFolder folder;
  RunContext context;
  WriteTextFile(folder / "a.nrrd", "x");
  WriteTextFile(folder / "atlas.json", R"({"format": "acus-atlas/1", "patients": [{"name": "one",
    "ct": "a.nrrd", "labels": "a.nrrd"}]})");
  const auto patients = ReadAtlas({folder.path()}, context);
  ASSERT_EQ(patients.size(), 1U);
  EXPECT_EQ(patients[0].ct, folder / "a.nrrd");
  EXPECT_EQ(patients[0].labels.file, folder / "a.nrrd");
  EXPECT_TRUE(patients[0].labels.mapping.empty()) << "found as for a map of --import";
  EXPECT_TRUE(ReadAtlas({}, context).empty());
}

TEST(AtlasFile, SeveralFoldersAreOneAtlasInWhichAPatientCountsOnce) {
  const TemporaryFolder folder;
  RunContext context;
  std::filesystem::create_directories(folder / "other");
  for (const char* ct : {"a.nrrd", "other/b.nrrd"}) WriteTextFile(folder / ct, "x");
  const auto patient = [](const std::string& ct) {
    return R"({"format": "acus-atlas/1", "patients": [{"name": "one", "ct": ")" + ct +
           R"(", "labels": ")" + ct + R"("}]})";
  };
  WriteTextFile(folder / "atlas.json", patient("a.nrrd"));
  WriteTextFile(folder / "other" / "atlas.json", patient("b.nrrd"));
  EXPECT_EQ(ReadAtlas({folder.path(), folder / "other"}, context).size(), 2U);
  WriteTextFile(folder / "other" / "atlas.json", patient("../a.nrrd"));
  EXPECT_THAT(
      [&] {
        ReadAtlas({folder.path(), folder / "other"}, context);
      },
      ThrowsMessage<InputError>(HasSubstr("is in the atlas already")));
}

}  // namespace
}  // namespace acus::atlas
