// The module graph is declared in lib/CMakeLists.txt; here every #include is held against it.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;
using Graph = std::map<std::string, std::set<std::string>>;

Graph ReadModuleGraph() {
  Graph graph;
  std::ifstream file(fs::path(ACUS_BUILD_DIR) / "modules.txt");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string module;
    words >> module;
    for (std::string dependency; words >> dependency;) graph[module].insert(dependency);
    graph[module];
  }
  return graph;
}

/// All that a module reaches through its declared dependencies.
std::set<std::string> Reachable(const Graph& graph, const std::string& module) {
  std::set<std::string> reached;
  std::vector<std::string> open{module};
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    for (const std::string& dependency : graph.at(next)) {
      if (reached.insert(dependency).second) open.push_back(dependency);
    }
  }
  return reached;
}

TEST(ModuleGraph, HasNoCycle) {
  const Graph graph = ReadModuleGraph();
  ASSERT_FALSE(graph.empty());
  for (const auto& [module, dependencies] : graph) {
    EXPECT_FALSE(Reachable(graph, module).contains(module)) << module << " depends on itself";
  }
}

TEST(ModuleGraph, EveryFolderOfLibIsAModule) {
  const Graph graph = ReadModuleGraph();
  for (const auto& entry : fs::directory_iterator(fs::path(ACUS_SOURCE_DIR) / "lib")) {
    if (!entry.is_directory()) continue;
    EXPECT_TRUE(graph.contains(entry.path().filename().string())) << entry.path();
  }
}

TEST(ModuleGraph, EveryIncludeFollowsIt) {
  const Graph graph = ReadModuleGraph();
  const std::regex include(R"re(^\s*#\s*include\s*"([a-z_]+)/)re");
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(ACUS_SOURCE_DIR) / "lib")) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    const std::string module =
        fs::relative(entry.path(), fs::path(ACUS_SOURCE_DIR) / "lib").begin()->string();
    std::set<std::string> allowed = graph.at(module);
    allowed.insert(module);
    std::ifstream file(entry.path());
    int number = 0;
    for (std::string line; std::getline(file, line);) {
      ++number;
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      EXPECT_TRUE(allowed.contains(match[1])) << entry.path().string() << ":" << number << ": "
                                              << module << " must not include " << match[1];
    }
  }
}

TEST(Headers, KeepThirdPartyLibrariesOut) {
  const std::regex heavy(R"re(#\s*include\s*<(itk|vtk|opencv|tetgen|ceres|igtl))re");
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(ACUS_SOURCE_DIR) / "lib")) {
    if (entry.path().extension() != ".h") continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      EXPECT_FALSE(std::regex_search(line, heavy)) << entry.path() << ": " << line;
    }
  }
}

TEST(Files, AreOneIdeaEach) {
  for (const char* folder : {"lib", "apps", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ACUS_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      int lines = 0;
      for (std::string line; std::getline(file, line);) ++lines;
      EXPECT_LE(lines, std::string(folder) == "apps" ? 100 : 600) << entry.path();
    }
  }
}

}  // namespace
