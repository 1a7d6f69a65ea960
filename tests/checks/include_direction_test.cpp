// The module graph is declared in lib/CMakeLists.txt; here every #include is held against it.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "checks/module_graph.h"

namespace acus::checks {
namespace {

namespace fs = std::filesystem;

const fs::path kLib = fs::path(ACUS_SOURCE_DIR) / "lib";

/// The position of each module, by its name.
std::map<std::string, std::size_t> PositionsOf(const std::vector<Module>& modules) {
  std::map<std::string, std::size_t> positions;
  for (std::size_t i = 0; i < modules.size(); ++i) positions[modules[i].name] = i;
  return positions;
}

/// The module in whose folder `path`, relative to lib/, lies. Nothing if it lies in none.
std::optional<std::string> ModuleOf(const std::vector<Module>& modules, const fs::path& path) {
  for (const Module& module : modules) {
    // A module of many parts has a folder for each of them.
    const fs::path folder = path.parent_path();
    if (folder == module.Folder() || folder.parent_path() == module.Folder()) return module.name;
  }
  return std::nullopt;
}

/// Paths below `folder`, relative to lib/, that end on one of `extensions`.
std::vector<fs::path> SourcesOf(const fs::path& folder, const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (extensions.contains(entry.path().extension().string())) {
      files.push_back(entry.path().lexically_relative(kLib));
    }
  }
  return files;
}

TEST(ModuleGraph, EachModuleHasOneName) {
  const std::vector<Module> modules = ReadModules();
  ASSERT_FALSE(modules.empty());
  EXPECT_EQ(PositionsOf(modules).size(), modules.size());
}

TEST(ModuleGraph, TheModulesOfAWingStandTogether) {
  const std::vector<Module> modules = ReadModules();
  std::set<std::string> closed;
  for (std::size_t i = 0; i < modules.size(); ++i) {
    EXPECT_FALSE(closed.contains(modules[i].wing))
        << modules[i].name << " stands in wing " << modules[i].wing << " after another wing";
    if (i + 1 < modules.size() && modules[i + 1].wing != modules[i].wing) {
      closed.insert(modules[i].wing);
    }
  }
}

// So there is no cycle, and no wing depends on a higher one.
TEST(ModuleGraph, ModulesDependOnEarlierOnesOnly) {
  const std::vector<Module> modules = ReadModules();
  const auto positions = PositionsOf(modules);
  for (std::size_t i = 0; i < modules.size(); ++i) {
    for (const std::string& dependency : modules[i].dependencies) {
      const auto found = positions.find(dependency);
      ASSERT_NE(found, positions.end())
          << modules[i].name << " depends on " << dependency << ", which is no module";
      EXPECT_LT(found->second, i) << modules[i].name << " (wing " << modules[i].wing
                                  << ") depends on " << dependency << " (wing "
                                  << modules[found->second].wing << "), which stands after it";
    }
  }
}

TEST(ModuleGraph, EveryFolderOfLibIsAWingAndEverySubfolderAModule) {
  const std::vector<Module> modules = ReadModules();
  const std::vector<std::string> wings = WingsOf(modules);
  std::set<std::string> folders;
  for (const Module& module : modules) folders.insert(module.Folder());
  std::set<std::string> there;
  for (const auto& wing : fs::directory_iterator(kLib / "acus")) {
    ASSERT_TRUE(wing.is_directory()) << wing.path() << " lies in no wing";
    EXPECT_NE(std::ranges::find(wings, wing.path().filename().string()), wings.end())
        << wing.path() << " is no wing";
  }
  for (const fs::path& file : SourcesOf(kLib, {".h", ".cpp"})) {
    const auto module = ModuleOf(modules, file);
    ASSERT_TRUE(module.has_value()) << file << " lies in no module";
    there.insert(modules[PositionsOf(modules).at(*module)].Folder());
  }
  EXPECT_EQ(there, folders);
}

TEST(ModuleGraph, EveryIncludeFollowsIt) {
  const std::vector<Module> modules = ReadModules();
  const auto positions = PositionsOf(modules);
  const std::regex include(R"re(^\s*#\s*include\s*"([^"]+)")re");
  std::size_t num_includes = 0;
  for (const fs::path& file : SourcesOf(kLib, {".h", ".cpp"})) {
    const auto module = ModuleOf(modules, file);
    ASSERT_TRUE(module.has_value()) << file << " lies in no module";
    std::set<std::string> allowed = modules[positions.at(*module)].dependencies;
    allowed.insert(*module);
    std::ifstream in(kLib / file);
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      ++num_includes;
      const std::string where = "lib/" + file.string() + ":" + std::to_string(number) + ": ";
      const std::string path = match[1];
      EXPECT_TRUE(fs::is_regular_file(kLib / path)) << where << path << " is not in lib/";
      const auto included = ModuleOf(modules, path);
      ASSERT_TRUE(included.has_value()) << where << path << " is of no module";
      EXPECT_TRUE(allowed.contains(*included))
          << where << *module << " must not include " << *included;
    }
  }
  EXPECT_GT(num_includes, 1000U);
}

// Who uses the library names files of it by their whole path, too.
TEST(ModuleGraph, IncludesOfProgramsAndTestsLeadToFiles) {
  const std::regex include(R"re(^\s*#\s*include\s*"(acus/[^"]+)")re");
  for (const char* folder : {"apps", "tests"}) {
    for (const fs::path& file : SourcesOf(kLib.parent_path() / folder, {".h", ".cpp"})) {
      std::ifstream in(kLib / file);
      for (std::string line; std::getline(in, line);) {
        std::smatch match;
        if (!std::regex_search(line, match, include)) continue;
        EXPECT_TRUE(fs::is_regular_file(kLib / match[1].str())) << file << ": " << match[1];
      }
    }
  }
}

TEST(Headers, KeepThirdPartyLibrariesOut) {
  const std::regex heavy(R"re(#\s*include\s*<(itk|vtk|opencv|embree|tetgen|ceres|igtl|CLI))re");
  for (const fs::path& file : SourcesOf(kLib, {".h"})) {
    std::ifstream in(kLib / file);
    for (std::string line; std::getline(in, line);) {
      EXPECT_FALSE(std::regex_search(line, heavy)) << file << ": " << line;
    }
  }
}

TEST(Files, AreOneIdeaEach) {
  for (const std::string folder : {"lib", "apps", "tests"}) {
    for (const fs::path& file : SourcesOf(kLib.parent_path() / folder, {".h", ".cpp"})) {
      std::ifstream in(kLib / file);
      int lines = 0;
      for (std::string line; std::getline(in, line);) ++lines;
      EXPECT_LE(lines, folder == "apps" ? 100 : 600) << file;
    }
  }
}

}  // namespace
}  // namespace acus::checks
