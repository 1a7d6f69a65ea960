// What made a file: program, version, command line, seed and the hashes of what it read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acus/base/core/version.h"

namespace acus {

/// SHA-256 of a file's bytes, or of a folder's files (names and bytes, in order of name), as hex.
/// @throws InputError if the path cannot be read.
std::string Sha256OfPath(const std::filesystem::path& path);

/// SHA-256 of a text, as hex.
std::string Sha256OfText(const std::string& text);

/// Written into every output, so that any result can be traced and made again.
struct Provenance {
  std::string program;
  std::string version = Version();
  std::string command_line;
  std::uint64_t seed = 0;
  std::map<std::string, std::string> input_sha256;  ///< By path as the user gave it.

  /// Remembers an input by its hash.
  void AddInput(const std::filesystem::path& path);

  nlohmann::json ToJson() const;

  /// One line, for file formats that only have a comment.
  std::string OneLine() const;
};

}  // namespace acus
