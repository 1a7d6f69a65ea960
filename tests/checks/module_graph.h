// The module graph as the build has it, for tests: rows "wing module dependency ..." of
// modules.txt.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace acus::checks {

struct Module {
  std::string wing;
  std::string name;
  std::set<std::string> dependencies;

  /// Where it lies below lib/: "acus/data/mesh". A wing of one module is that module.
  std::string Folder() const { return "acus/" + wing + (name == wing ? "" : "/" + name); }
};

/// In the order of lib/CMakeLists.txt.
inline std::vector<Module> ReadModules() {
  std::vector<Module> modules;
  std::ifstream file(std::filesystem::path(ACUS_BUILD_DIR) / "modules.txt");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    Module module;
    words >> module.wing >> module.name;
    for (std::string dependency; words >> dependency;) module.dependencies.insert(dependency);
    modules.push_back(module);
  }
  return modules;
}

/// The wings, from the lowest to the highest.
inline std::vector<std::string> WingsOf(const std::vector<Module>& modules) {
  std::vector<std::string> wings;
  for (const Module& module : modules) {
    if (std::ranges::find(wings, module.wing) == wings.end()) wings.push_back(module.wing);
  }
  return wings;
}

}  // namespace acus::checks
