// Where the public data sets for tests are. They are not part of the project.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace acus::testing_support {

/// A file or folder of the test data: $ACUS_TEST_DATA, or ../shared/data beside the source tree.
/// Nothing if it is not there: then `GTEST_SKIP() << "test data ... is not here"`.
inline std::optional<std::filesystem::path> SharedData(const char* name) {
  const char* folder = std::getenv("ACUS_TEST_DATA");
  const std::filesystem::path root =
      folder != nullptr ? folder
                        : std::filesystem::path(ACUS_SOURCE_DIR) / ".." / "shared" / "data";
  std::filesystem::path path = root / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}

}  // namespace acus::testing_support
