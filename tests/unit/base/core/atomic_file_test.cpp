#include "acus/base/core/atomic_file.h"

#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/output_check.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/provenance.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

int NumEntries(const fs::path& folder) {
  return static_cast<int>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  {
    const AtomicFile file(folder / "a.csv");
    std::ofstream(file.path()) << "half";
    EXPECT_EQ(file.path().extension(), ".csv");
  }
  EXPECT_EQ(NumEntries(folder), 0);
  WriteTextFile(folder / "a.csv", "whole");
  EXPECT_EQ(ReadTextFile(folder / "a.csv"), "whole");
  EXPECT_EQ(NumEntries(folder), 1);
}

TEST(AtomicFolder, ReplacesOnlyEarlierOutput) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const fs::path run = folder / "run";
  {
    AtomicFolder output(run, false);
    WriteTextFile(output.path() / "provenance.json", "{}");
    output.Commit();
  }
  EXPECT_THAT([&] { AtomicFolder(run, false); },
              ThrowsMessage<InputError>(HasSubstr("--overwrite")));
  {
    AtomicFolder output(run, true);
    WriteTextFile(output.path() / "new", "");
    output.Commit();
  }
  EXPECT_TRUE(fs::exists(run / "new"));
  EXPECT_THAT([&] { AtomicFolder(run, true); },
              ThrowsMessage<InputError>(HasSubstr("not the output of an earlier run")));
  EXPECT_EQ(NumEntries(folder), 1);
}

TEST(AtomicFolder, DoesNotReplaceWhatCameToBeThereMeanwhile) {
  const testing_support::TemporaryFolder temporary;
  const fs::path run = temporary.path() / "run";
  const auto fill = [](const AtomicFolder& output, const char* text) {
    WriteTextFile(output.path() / "provenance.json", text);
  };
  AtomicFolder first(run, false);
  AtomicFolder second(run, false);
  AtomicFolder third(run, true);
  fill(first, "first");
  fill(second, "second");
  fill(third, "third");
  second.Commit();
  EXPECT_THAT([&] { first.Commit(); }, ThrowsMessage<InputError>(HasSubstr("exists already")));
  EXPECT_EQ(ReadTextFile(run / "provenance.json"), "second");
  {
    const FolderLock recording(run);
    EXPECT_THAT([&] { third.Commit(); },
                ThrowsMessage<InputError>(HasSubstr("another program is writing")));
    EXPECT_THAT([&] { AtomicFolder(run, true); },
                ThrowsMessage<InputError>(HasSubstr("another program is writing")));
  }
  third.Commit();
  EXPECT_EQ(ReadTextFile(run / "provenance.json"), "third");
}

TEST(AtomicFolder, FillsAnEmptyFolderAndWhatALinkPointsTo) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directory(folder / "real");
  fs::create_symlink(folder / "real", folder / "link");
  AtomicFolder output(folder / "link", false);
  WriteTextFile(output.path() / "new", "");
  output.Commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_TRUE(fs::exists(folder / "real" / "new"));
  EXPECT_EQ(NumEntries(folder), 2);
}

TEST(AtomicFolder, TakesRelativePathsAndTrailingSlashes) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  for (const char* name : {"run", "slash/", "./dot", "deep/er/run", "deep/../up"}) {
    AtomicFolder output(name, false);
    WriteTextFile(output.path() / "new", "");
    output.Commit();
    EXPECT_TRUE(fs::exists(folder / name / "new")) << name;
  }
  WriteTextFile("file.txt", "text");
  EXPECT_EQ(ReadTextFile(folder / "file.txt"), "text");
  fs::current_path(before);
}

TEST(AtomicFolder, WithoutCommitTheEarlierOutputStays) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directory(folder / "run");
  WriteTextFile(folder / "run" / "provenance.json", "old");
  {
    const AtomicFolder output(folder / "run", true);
    WriteTextFile(output.path() / "provenance.json", "new");
  }
  EXPECT_EQ(ReadTextFile(folder / "run" / "provenance.json"), "old");
  EXPECT_EQ(NumEntries(folder), 1);
}

TEST(RequireFolderCanBeMade, RefusesWhatAtomicFolderRefusesAndLeavesNothing) {
  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  RequireFolderCanBeMade(folder / "run", false);
  RequireFolderCanBeMade(folder / "deep" / "er" / "run", false);
  EXPECT_EQ(NumEntries(folder), 0);
  fs::create_directory(folder / "full");
  WriteTextFile(folder / "full" / "mine", "text");
  EXPECT_THROW(RequireFolderCanBeMade(folder / "full", false), InputError);
  EXPECT_THROW(RequireFolderCanBeMade(folder / "full", true), InputError);
  EXPECT_THROW(RequireFolderCanBeMade(folder / "full" / "mine" / "run", false), InputError);
  WriteTextFile(folder / "full" / "provenance.json", "{}");
  RequireFolderCanBeMade(folder / "full", true);
  EXPECT_EQ(NumEntries(folder / "full"), 2);
  EXPECT_THROW(RequireFolderCanBeMade(folder / std::string(300, 'a'), false), InputError);
  EXPECT_THROW(RequireFolderCanBeMade(folder / "new" / std::string(300, 'a'), false), InputError);
  EXPECT_THROW(RequireFolderCanBeMade("/proc/run", false), InputError);
  EXPECT_EQ(NumEntries(folder), 1);
}

TEST(Sha256, MatchesThePublishedTestVector) {
  EXPECT_EQ(Sha256OfText("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(ParallelFor, CallsEachPieceOnceAndRethrows) {
  std::vector<int> calls(1000, 0);
  ParallelFor(1000, 4, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
  EXPECT_THAT(calls, testing::Each(1));
  EXPECT_THROW(ParallelFor(10, 2, [](int) { throw InputError("x"); }), InputError);
}

}  // namespace
}  // namespace acus
