// A session that another program requests of a running acus-live.
#pragma once

#include <filesystem>
#include <string>

namespace acus::live {

/// The command line's options of the same names.
struct SessionRequest {
  std::filesystem::path output;
  std::filesystem::path scenario;  ///< Empty: that of the command line.
  std::filesystem::path exercise;  ///< Empty: none.
  std::filesystem::path hand;      ///< Empty: the devices file decides.
  double duration_s = 0.0;         ///< 0: until it is stopped.
  int trial = 1;
  std::string caption;  ///< Below the exercise's name; may be empty.
  bool left_handed = false;
  std::filesystem::path screenshot;  ///< Empty: none.
};

/// @param line  JSON (acus-session-request).
/// @throws InputError if it is no JSON, or violates the schema.
SessionRequest ParseSessionRequest(const std::string& line);

}  // namespace acus::live
