#include "acus/base/core/shown_path.h"

#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

class ShownPathTest : public ::testing::Test {
 protected:
  ~ShownPathTest() override { ShowFolders(true); }
};

TEST_F(ShownPathTest, IsThePathByDefault) {
  EXPECT_EQ(ShownPath("/data/Jane Doe/ct.nrrd"), "/data/Jane Doe/ct.nrrd");
  EXPECT_EQ(ShownWord("--ct=a/b.nrrd"), "--ct=a/b.nrrd");
  EXPECT_EQ(ShownText("/data/Jane Doe/ct.nrrd: thin"), "/data/Jane Doe/ct.nrrd: thin");
}

TEST_F(ShownPathTest, IsTheNameOnlyWhereFoldersAreHidden) {
  ShowFolders(false);
  EXPECT_EQ(ShownPath("/data/Jane Doe/ct.nrrd"), "ct.nrrd");
  EXPECT_EQ(ShownPath("Jane Doe/session/"), "session");
  EXPECT_EQ(ShownPath("ct.nrrd"), "ct.nrrd");
  EXPECT_EQ(ShownText("/data/Jane Doe/ct.nrrd: thin; see Jane Doe/session"),
            "ct.nrrd: thin; see session");
}

TEST_F(ShownPathTest, HoldsForWordsOfACommandLine) {
  ShowFolders(false);
  EXPECT_EQ(ShownWord("/data/Jane/ct.nrrd"), "ct.nrrd");
  EXPECT_EQ(ShownWord("/data/Jane Doe/ct.nrrd"), "ct.nrrd");
  EXPECT_EQ(ShownWord("--ct=../Jane/ct.nrrd"), "--ct=ct.nrrd");
  EXPECT_EQ(ShownWord("/patient/ct=/data/Jane/ct.nrrd"), "/patient/ct=ct.nrrd");
  EXPECT_EQ(ShownWord("--overwrite"), "--overwrite");
  EXPECT_EQ(ShownWord("/effects/ultrasound/needle=false"), "/effects/ultrasound/needle=false");
}

TEST_F(ShownPathTest, KeepsTheHashesOfFilesWithOneName) {
  const fs::path folder =
      fs::temp_directory_path() / Message("acus_shown_path_", static_cast<int>(::getpid()));
  Provenance provenance;
  ShowFolders(false);
  for (const char* patient : {"a", "b"}) {
    fs::create_directories(folder / patient);
    std::ofstream(folder / patient / "ct") << patient;
    provenance.AddInput(folder / patient / "ct");
    provenance.AddInput(folder / patient / "ct");
  }
  fs::remove_all(folder);
  EXPECT_EQ(provenance.input_sha256.size(), 2U);
  EXPECT_EQ(provenance.input_sha256.at("ct"), Sha256OfText("a"));
  EXPECT_EQ(provenance.input_sha256.at("ct (2)"), Sha256OfText("b"));
}

}  // namespace
}  // namespace acus
