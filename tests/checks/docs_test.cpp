// What the hand-written pages say about the tree is held against it.
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <string>
#include <vector>

#include "acus/base/core/atomic_file.h"
#include "checks/module_graph.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = ACUS_SOURCE_DIR;

std::vector<fs::path> Pages() {
  std::vector<fs::path> pages{kRoot / "README.md", kRoot / "CONTRIBUTING.md",
                              kRoot / "CHANGELOG.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  return pages;
}

std::vector<std::string> Matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    found.push_back((*match)[1]);
  }
  return found;
}

TEST(Docs, LinksLeadToFiles) {
  const std::regex link(R"re(\]\(([^)#\s]+))re");
  int num_links = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& target : Matches(ReadTextFile(page), link)) {
      if (target.starts_with("http")) continue;
      EXPECT_TRUE(fs::exists(page.parent_path() / target)) << page << ": " << target;
      ++num_links;
    }
  }
  EXPECT_GT(num_links, 20);
}

TEST(Docs, FilesThatAreNamedAreThere) {
  const std::regex path(
      R"re(`((?:lib|apps|tests|configs|docs|developer|pipelines)/[\w./-]*\.[a-z]+)`)re");
  for (const fs::path& page : Pages()) {
    for (const std::string& name : Matches(ReadTextFile(page), path)) {
      EXPECT_TRUE(fs::exists(kRoot / name)) << page << ": " << name;
    }
  }
}

TEST(Docs, CommandsThatAreNamedAreThere) {
  const std::regex command(R"re((?:^|[\s`(])((?:pipelines|developer)/[\w-]+))re");
  int num_commands = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& name : Matches(ReadTextFile(page), command)) {
      EXPECT_TRUE(fs::exists(kRoot / name)) << page << ": " << name;
      ++num_commands;
    }
  }
  EXPECT_GT(num_commands, 100);
}

// In the order in which the build has them: from the lowest to the highest.
TEST(Docs, ArchitectureListsTheWingsAndModulesThatThereAre) {
  const std::string text = ReadTextFile(kRoot / "docs" / "architecture.md");
  const auto begin = text.find("## Wings and modules of `lib/`");
  ASSERT_NE(begin, text.npos);
  const std::string section = text.substr(begin, text.find("\n## ", begin) - begin);
  const auto modules = checks::ReadModules();
  EXPECT_EQ(Matches(section, std::regex(R"re(\n\d+\. \*\*(\w+)\*\*)re")), checks::WingsOf(modules));
  std::vector<std::string> rows;
  for (const auto& module : modules) rows.push_back(module.wing + "` | `" + module.name);
  EXPECT_EQ(Matches(section, std::regex(R"re(\n\| `(\w+` \| `\w+)` \|)re")), rows);
}

TEST(Docs, TheFigureOfTheWingsIsThatOfTheBuild) {
  const std::string root = kRoot.string();
  const std::string command =
      "python3 '" + root + "/developer/module-graph' --check '" ACUS_BUILD_DIR "/modules.txt'";
  EXPECT_EQ(std::system(command.c_str()), 0) << "run developer/module-graph";
}

TEST(Docs, EveryTextThatATraineeReadsIsTranslated) {
  if (std::system("command -v xgettext >/dev/null") != 0) GTEST_SKIP() << "needs package gettext";
  const std::string command = "python3 '" + kRoot.string() + "/developer/translations' --check";
  EXPECT_EQ(std::system(command.c_str()), 0) << "run developer/translations";
}

}  // namespace
}  // namespace acus
