#include "acus/base/core/trusted_library.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

TEST(LibraryWord, IsAnAbsolutePathOrAName) {
  for (const char* word : {"", "libdhd.so.3", "/opt/vendor/lib/libdhd.so.3", "lib with blank.so"}) {
    EXPECT_NO_THROW(CheckLibraryWord(word, "d.json: /devices/0/library")) << word;
  }
  for (const char* word : {"./libdhd.so.3", "../libdhd.so.3", "drivers/libdhd.so.3", "libdhd.so.3/",
                           "$ORIGIN/libdhd.so.3", "/opt/$LIB/libdhd.so.3", "$LIB"}) {
    EXPECT_THAT([&] { CheckLibraryWord(word, "d.json: /devices/0/library"); },
                ThrowsMessage<InputError>(
                    AllOf(HasSubstr(Message("d.json: /devices/0/library: is '", word, "'")),
                          HasSubstr("allowed: an absolute path"))))
        << word;
  }
}

/// A library in two folders, which nobody but this user may write.
class LibraryFile : public testing::Test {
 protected:
  LibraryFile() {
    fs::create_directories(inner_);
    WriteTextFile(file_, "no library, and not loaded");
    for (const fs::path& path : {folder_.path(), outer_, inner_, file_}) {
      fs::permissions(path, fs::perms::owner_all);
    }
  }
  void ExpectRefused(const fs::path& path, const std::string& why) const {
    EXPECT_THAT([&] { TrustedFile(path, "OpenHaptics"); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("OpenHaptics: "), HasSubstr(why))));
  }

  TemporaryFolder folder_;
  fs::path outer_ = folder_ / "outer";
  fs::path inner_ = outer_ / "inner";
  fs::path file_ = inner_ / "libHD.so";
};

TEST_F(LibraryFile, IsTakenIfNoOtherUserCanChangeIt) {
  EXPECT_EQ(TrustedFile(file_, "OpenHaptics"), fs::canonical(file_));
  EXPECT_EQ(TrustedFile(outer_ / "../outer/inner/./libHD.so", "OpenHaptics"), fs::canonical(file_));
  // Others may read and run it.
  fs::permissions(file_, fs::perms(0755));
  fs::permissions(outer_, fs::perms(0755));
  EXPECT_NO_THROW(TrustedFile(file_, "OpenHaptics"));
}

TEST_F(LibraryFile, IsRefusedIfOthersMayWriteItOrAFolderAboveIt) {
  for (const fs::path& path : {file_, inner_, outer_}) {
    fs::permissions(path, fs::perms(0770));
    ExpectRefused(file_, Message(fs::canonical(path).string(), " may be written by its group"));
    fs::permissions(path, fs::perms(0702));
    ExpectRefused(file_, Message(fs::canonical(path).string(), " may be written by everybody"));
    ExpectRefused(file_, "chmod go-w");
    fs::permissions(path, fs::perms(0700));
    EXPECT_NO_THROW(TrustedFile(file_, "OpenHaptics")) << path;
  }
}

TEST_F(LibraryFile, MayLieInAFolderOfAllWithTheStickyBit) {
  fs::permissions(outer_, fs::perms(01777));
  EXPECT_NO_THROW(TrustedFile(file_, "OpenHaptics"));
  fs::permissions(file_, fs::perms(01770));  // Means nothing on a file.
  ExpectRefused(file_, "may be written by its group");
}

TEST_F(LibraryFile, IsJudgedWhereLinksLead) {
  const fs::path link = folder_ / "link.so";
  fs::create_symlink(file_, link);
  EXPECT_EQ(TrustedFile(link, "OpenHaptics"), fs::canonical(file_));
  fs::permissions(inner_, fs::perms(0777));
  ExpectRefused(link, Message(fs::canonical(inner_).string(), " may be written by everybody"));
  fs::remove(file_);
  ExpectRefused(link, "no such file");
}

TEST_F(LibraryFile, IsARegularFile) {
  ExpectRefused(inner_, "is not a regular file");
  ExpectRefused("/dev/null", "is not a regular file");
  ExpectRefused(inner_ / "gone.so", "gone.so: no such file");
}

TEST_F(LibraryFile, BelongsToRootOrTheUser) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  constexpr uid_t kNobody = 65534;
  for (const fs::path& path : {file_, inner_, outer_}) {
    ASSERT_EQ(chown(path.c_str(), kNobody, gid_t(-1)), 0);
    ExpectRefused(
        file_, Message(fs::canonical(path).string(), " belongs to the user with number ", kNobody));
    ASSERT_EQ(chown(path.c_str(), 0, gid_t(-1)), 0);
  }
}

}  // namespace
}  // namespace acus
