#include "acus/base/core/folder_lock.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

class FolderLockTest : public ::testing::Test {
 protected:
  FolderLockTest() { fs::create_directories(folder_); }
  ~FolderLockTest() override { fs::remove_all(folder_); }
  fs::path folder_ =
      fs::temp_directory_path() / Message("acus_folder_lock_", static_cast<int>(::getpid()));
};

TEST_F(FolderLockTest, IsHeldByOneAtATime) {
  {
    const FolderLock lock(folder_);
    EXPECT_TRUE(lock.holds());
    EXPECT_THROW(FolderLock{folder_}, InputError);
  }
  EXPECT_TRUE(FolderLock(folder_).holds());
}

TEST_F(FolderLockTest, MovesWithItsOwner) {
  FolderLock kept;
  EXPECT_FALSE(kept.holds());
  kept = FolderLock(folder_);
  EXPECT_TRUE(kept.holds());
  EXPECT_THROW(FolderLock{folder_}, InputError);
  const FolderLock moved(std::move(kept));
  EXPECT_THROW(FolderLock{folder_}, InputError);
}

}  // namespace
}  // namespace acus
