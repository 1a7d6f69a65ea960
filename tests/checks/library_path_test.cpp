// No program runs what lies in the working directory: the loader is given no place to search that
// is empty or relative, in the build folder as when installed.
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>
#include <sstream>
#include <string>
#include <vector>

#include "support/elf_search.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::IsEmpty;
using testing::UnorderedElementsAre;
using testing_support::ElfFile;
using testing_support::TemporaryFolder;

const fs::path kBuilt = fs::path(ACUS_BUILD_DIR) / "bin";

std::vector<fs::path> ProgramsIn(const fs::path& folder) {
  std::vector<fs::path> programs;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && ElfFile(entry.path()).is_elf()) programs.push_back(entry.path());
  }
  return programs;
}

/// What of the file means the working directory to the loader.
std::vector<std::string> Relative(const fs::path& file) {
  const auto search = ElfFile(file).Search();
  std::vector<std::string> relative;
  for (const std::string& folder : search.folders) {
    if (!folder.starts_with('/')) relative.push_back("'" + folder + "'");
  }
  // A name without a slash is searched for; any other is a path as it stands.
  for (const std::string& library : search.libraries) {
    const auto slash = library.find('/');
    if (slash != library.npos && slash != 0) relative.push_back("'" + library + "'");
  }
  return relative;
}

TEST(LibraryPath, OfWhatIsBuiltIsAbsolute) {
  const std::vector<fs::path> programs = ProgramsIn(kBuilt);
  EXPECT_FALSE(programs.empty()) << "no program in " << kBuilt;
  for (const fs::path& program : programs) EXPECT_THAT(Relative(program), IsEmpty()) << program;
}

TEST(LibraryPath, OfWhatIsInstalledIsAbsolute) {
  const TemporaryFolder folder;
  std::istringstream names(ACUS_PROGRAMS);
  for (std::string name; std::getline(names, name, ',');) {
    if (!fs::exists(kBuilt / name)) continue;  // Only some may be built.
    const std::string command = std::string("env -u DESTDIR '") + ACUS_CMAKE + "' --install '" +
                                ACUS_BUILD_DIR + "' --component " + name + " --prefix '" +
                                folder.path().string() + "' >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const fs::path installed = folder / "bin" / name;
    ASSERT_TRUE(fs::exists(installed)) << installed;
    EXPECT_THAT(Relative(installed), IsEmpty()) << installed;
    fs::remove(installed);
  }
}

TEST(LibraryPath, ThatIsNotAbsoluteIsSeen) {
  const fs::path program = fs::path(ACUS_BUILD_DIR) / "tests" / "program_with_relative_rpath";
  EXPECT_THAT(Relative(program), UnorderedElementsAre("''", "'lib'"));
  EXPECT_THAT(ElfFile(program).Search().folders, Contains("/opt/absolute"));
  EXPECT_THAT(ElfFile(program).Search().libraries, Contains("libc.so.6"));
}

}  // namespace
}  // namespace acus
