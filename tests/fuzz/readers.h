// Every reader of files and messages that come from outside, each as one call on one file.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace acus::fuzz {

struct Reader {
  std::string_view name;
  std::string_view extension;  ///< By which readers of several formats choose, with its dot.
  /// Reads the file. @throws InputError if it is refused; anything else is a finding.
  void (*read)(const std::filesystem::path& file);
  /// Writes valid files into the folder, as small as they can be.
  void (*write_seeds)(const std::filesystem::path& folder);
};

std::span<const Reader> Readers();

/// Calls the reader; a refusal is an answer.
void ReadOrRefuse(const Reader& reader, const std::filesystem::path& file);

}  // namespace acus::fuzz
