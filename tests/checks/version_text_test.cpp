// lib/version.cmake, which names a build, in repositories and folders made for it.
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>
#include <string>

#include "acus/base/core/atomic_file.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class VersionText : public testing::Test {
 protected:
  VersionText() { fs::create_directory(source_); }

  /// The text that a build of `source` would compile.
  std::string TextOf(const fs::path& source) {
    Run("cmake -D SOURCE='" + source.string() + "' -D VERSION=1.2.3 -D OUTPUT='" +
        output_.string() + "' -P '" ACUS_SOURCE_DIR "/lib/version.cmake'");
    return ReadTextFile(output_);
  }

  void Git(const std::string& arguments) {
    Run("git -C '" + source_.string() + "' -c user.name=N -c user.email=N " + arguments);
  }

  static void Run(const std::string& command) {
    ASSERT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0) << command;
  }

  testing_support::TemporaryFolder temporary_;
  fs::path source_ = temporary_.path() / "source";
  fs::path output_ = temporary_.path() / "version.cpp";
};

constexpr const char* kNumberAlone = "Version() { return \"1.2.3\"; }";

TEST_F(VersionText, IsTheNumberAloneInAnArchive) {
  EXPECT_THAT(TextOf(source_), HasSubstr(kNumberAlone));
}

TEST_F(VersionText, NamesCommitTagAndChanges) {
  if (std::system("git --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no git";
  Git("init");
  EXPECT_THAT(TextOf(source_), HasSubstr(kNumberAlone)) << "no commit yet";
  WriteTextFile(source_ / "a", "1");
  Git("add a");
  Git("commit -m first");
  EXPECT_THAT(TextOf(source_),
              ContainsRegex(" Version\\(\\) \\{ return \"1\\.2\\.3 \\([0-9a-f]+\\)\""));
  EXPECT_THAT(TextOf(source_), HasSubstr("VersionNumber() { return \"1.2.3\"; }"));
  WriteTextFile(source_ / "a", "2");
  EXPECT_THAT(TextOf(source_), HasSubstr("-dirty)"));
  Git("commit -a -m second");
  Git("tag v1.2.3");
  EXPECT_THAT(TextOf(source_), HasSubstr("1.2.3 (v1.2.3)"));
  // An archive that was unpacked inside a repository is not that repository's.
  fs::create_directory(source_ / "inside");
  EXPECT_THAT(TextOf(source_ / "inside"), HasSubstr(kNumberAlone));
}

// Otherwise every build would compile and link again.
TEST_F(VersionText, IsNotWrittenAgainWhenNothingChanged) {
  TextOf(source_);
  const auto earlier = fs::file_time_type::clock::now() - std::chrono::hours(1);
  fs::last_write_time(output_, earlier);
  const auto before = fs::last_write_time(output_);
  const std::string text = TextOf(source_);
  EXPECT_EQ(fs::last_write_time(output_), before);
  WriteTextFile(output_, "something else");
  EXPECT_EQ(TextOf(source_), text);
}

}  // namespace
}  // namespace acus
