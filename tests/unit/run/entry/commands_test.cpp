#include "acus/run/entry/commands.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "acus/base/core/atomic_file.h"

namespace acus::entry {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::set<std::string> NamesOf(CommandKind kind) {
  std::set<std::string> names;
  for (const Command& command : Commands()) {
    if (command.kind != kind) continue;
    EXPECT_TRUE(names.emplace(command.name).second) << command.name;
  }
  return names;
}

TEST(EntryCommands, AreAllProgramsThatAreBuilt) {
  const std::string text = ReadTextFile(fs::path(ACUS_SOURCE_DIR) / "apps" / "CMakeLists.txt");
  const std::regex row("acus_add_program\\(acus-([a-z]+)");
  std::set<std::string> built;
  for (std::sregex_iterator match(text.begin(), text.end(), row), end; match != end; ++match) {
    built.insert((*match)[1]);
  }
  EXPECT_EQ(NamesOf(CommandKind::kProgram), built);
}

TEST(EntryCommands, AreAllWorkflowsThatAreInstalled) {
  const fs::path sources = ACUS_SOURCE_DIR;
  const std::string text = ReadTextFile(sources / "configs" / "CMakeLists.txt");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(text, match, std::regex("foreach\\(workflow ([^)]*)\\)")));
  std::istringstream words(match[1].str());
  std::set<std::string> installed;
  for (std::string word; words >> word;) installed.insert(word);
  EXPECT_EQ(NamesOf(CommandKind::kWorkflow), installed);
  for (const std::string& name : installed) {
    EXPECT_TRUE(fs::exists(sources / "pipelines" / name)) << name;
  }
}

TEST(EntryCommands, LieBesideTheProgramOrInItsShare) {
  EXPECT_EQ(FileOf(*FindCommand("replay"), "/usr/bin/acus"), "/usr/bin/acus-replay");
  EXPECT_EQ(FileOf(*FindCommand("demo"), "/usr/bin/acus"), "/usr/share/acus/pipelines/demo");
}

TEST(EntryCommands, HaveNoOthers) {
  EXPECT_FALSE(FindCommand("relpay"));
  EXPECT_FALSE(FindCommand(""));
}

TEST(EntryCommands, ReportWhatIsMissing) {
  char program[] = "acus";
  char word[] = "nothing";
  char* arguments[] = {program, word};
  const Command command{.name = "nothing", .kind = CommandKind::kProgram, .summary = ""};
  EXPECT_THAT(Become(command, arguments), HasSubstr("acus-nothing: missing"));
}

}  // namespace
}  // namespace acus::entry
