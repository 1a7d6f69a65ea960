// Text and images inside XML and HTML.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace acus::report {

/// `text` with & < > " ' escaped, for element content and attributes alike. Control characters,
/// which XML forbids, become spaces; bytes that are not UTF-8 become U+FFFD.
std::string Escaped(std::string_view text);

/// Number of Unicode characters of a UTF-8 text, for estimating its width.
int NumCharacters(std::string_view text);

/// "data:image/png;base64,..." of a PNG file. @throws InputError if the file cannot be read or is
/// not a PNG.
std::string PngDataUri(const std::filesystem::path& png);

}  // namespace acus::report
