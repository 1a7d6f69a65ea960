// Paths of optional files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

/// The path at `key`, relative to `folder`; empty if there is none. The reader of a file checks
/// that it exists: files that no effect reads need not.
inline std::filesystem::path OptionalPath(const nlohmann::json& object, const char* key,
                                          const std::filesystem::path& folder) {
  if (!object.contains(key)) return {};
  return (folder / object.at(key).get<std::string>()).lexically_normal();
}

}  // namespace acus::scenario
