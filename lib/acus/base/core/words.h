// Small work on text that every reader and every message needs.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus {

/// Without the blanks, tabs and line ends around it. A view into `text`.
std::string_view Trimmed(std::string_view text);

/// "a, b, c"
std::string Joined(std::span<const std::string> words, std::string_view separator = ", ");

/// The lines of a text, without their ends.
std::vector<std::string> LinesOf(std::string_view text);

}  // namespace acus
