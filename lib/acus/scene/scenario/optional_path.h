// Paths of files that need not be there.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

/// The path at `key`, relative to `folder`; empty if there is none. Whether the file is there is
/// found by what reads it: effects that are not called for look for nothing.
inline std::filesystem::path OptionalPath(const nlohmann::json& object, const char* key,
                                          const std::filesystem::path& folder) {
  if (!object.contains(key)) return {};
  return (folder / object.at(key).get<std::string>()).lexically_normal();
}

}  // namespace acus::scenario
