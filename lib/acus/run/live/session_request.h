// A session that another program requests of a running acus-live.
#pragma once

#include <filesystem>
#include <string>

namespace acus::live {

/// As the command line's options of the same names.
struct SessionRequest {
  std::filesystem::path output;
  std::filesystem::path scenario;  ///< Empty: that of the command line.
  std::filesystem::path exercise;  ///< Empty: none.
  std::filesystem::path hand;      ///< Empty: as the devices file says.
  double duration_s = 0.0;         ///< 0: until somebody ends it.
  int trial = 1;
  std::string caption;  ///< Below the exercise's name; may be empty.
  bool left_handed = false;
  std::filesystem::path screenshot;  ///< Empty: none.
};

/// @param line  JSON (acus-session-request).
/// @throws InputError: no JSON, or what the schema says.
SessionRequest ParseSessionRequest(const std::string& line);

}  // namespace acus::live
