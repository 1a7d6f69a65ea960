#include "acus/base/core/text_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"

namespace acus {
namespace {

/// Characters of a UTF-8 text.
std::size_t Width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80; }));
}

bool IsNumberOrNothing(const std::string& text) {
  return text.empty() || text == "-" || ParseNumber<double>(text);
}

}  // namespace

std::string TextTable(const std::vector<std::string>& header,
                      const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  std::vector<bool> right;
  for (std::size_t column = 0; column < header.size(); ++column) {
    widths.push_back(Width(header[column]));
    right.push_back(!rows.empty());
    for (const auto& row : rows) {
      ACUS_ASSERT(row.size() == header.size());
      widths[column] = std::max(widths[column], Width(row[column]));
      right[column] = right[column] && IsNumberOrNothing(row[column]);
    }
  }
  std::string text;
  const auto add_line = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string padding(widths[i] - Width(cells[i]), ' ');
      line += (i == 0 ? "" : "  ") + (right[i] ? padding + cells[i] : cells[i] + padding);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  };
  add_line(header);
  std::vector<std::string> rule;
  for (const std::size_t width : widths) rule.emplace_back(width, '-');
  add_line(rule);
  for (const auto& row : rows) add_line(row);
  return text;
}

std::string FixedText(double value, int decimals) {
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  std::array<char, 400> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                          std::chars_format::fixed, std::clamp(decimals, 0, 30));
  ACUS_ASSERT(error == std::errc());
  return {text.data(), end};
}

std::string RoundedText(double value, int digits) {
  const double size = std::abs(value);
  if (!std::isfinite(value) || (size < 1e9 && size >= std::pow(10.0, digits))) {
    return FixedText(value, 0);
  }
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                          std::chars_format::general, std::clamp(digits, 1, 17));
  ACUS_ASSERT(error == std::errc());
  return {text.data(), end};
}

}  // namespace acus
